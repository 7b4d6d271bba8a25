"""What is in the image of a board, and what may not be."""

from __future__ import annotations

import re
import subprocess

import pytest

from halfroll.boards import EMULATED
from hil.flights import sizes

BOARDS = ["qemu-m4", pytest.param("qemu-m7", marks=pytest.mark.long)]
FORBIDDEN = {
    "heap": r"^(_?malloc(_r)?|_?free(_r)?|_sbrk(_r)?|operator new.*|operator delete.*)$",
    "exceptions": r"^(__cxa_(?!pure_virtual)\w+|_Unwind_\w+|__gxx_personality\w*)$",
    "type information": r"^(typeinfo .*|__dynamic_cast)$",
    "double arithmetic in software": r"^__(aeabi_(d(?!ivmod)\w+|[fiu]?l?2d)|\w+df[23]|\w+df\w+)$",
    "functions that round as they like": r"^_*(ieee754_)?(hypot|sin|cos|tan|a?sin|a?cos|a?tan2?|exp|pow|log)f?$",
    "formatted output": r"^_?v?s?n?printf(_r)?$",
}


@pytest.fixture(scope="module", params=BOARDS)
def board(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    assert EMULATED[name].image.is_file(), "run `make boards`"
    return name


def symbols(board: str) -> list[str]:
    said = subprocess.run(["arm-none-eabi-nm", "-C", EMULATED[board].image], capture_output=True, text=True, check=True)
    return [line.split(maxsplit=2)[-1] for line in said.stdout.splitlines()]


@pytest.mark.parametrize("what", FORBIDDEN)
def test_the_image_is_free_of(board: str, what: str) -> None:
    names = [re.sub(r"\(.*", "", name) if "operator" in name else name for name in symbols(board)]
    assert [name for name in names if re.match(FORBIDDEN[what], name)] == []


def test_no_multiplication_is_fused_with_an_addition(board: str) -> None:
    """A fused one rounds once where the host rounds twice. (VMLA and its like are two roundings in one instruction.)"""
    code = subprocess.run(
        ["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", EMULATED[board].image],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert re.findall(r"\t(vfma|vfms|vfnma|vfnms)\.f\d+", code) == []
    assert len(re.findall(r"\tvmul\.f32", code)) > 100


def test_it_fits_the_flash_and_the_stack_reserved_is_known(board: str) -> None:
    assert sizes(board)["flash_bytes"] <= 256 * 1024

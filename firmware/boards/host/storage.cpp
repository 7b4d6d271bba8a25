#include "boards/host/storage.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace halfroll::host {
namespace {

std::vector<std::uint8_t> contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

bool write_all(int file, const std::uint8_t* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(file, bytes, size);
    if (written <= 0) return false;
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

}  // namespace

Storage::Storage(std::string directory) : directory_(std::move(directory)) {
  if (directory_.empty()) return;
  std::error_code failed;
  std::filesystem::create_directories(directory_, failed);
  if (!std::filesystem::is_directory(directory_)) {
    throw std::runtime_error("--storage " + directory_ + " is not a directory and cannot be made one");
  }
  params_ = contents(path(link::StorageSlot::kParams));
  mission_ = contents(path(link::StorageSlot::kMission));
}

std::string Storage::path(link::StorageSlot slot) const {
  return directory_ + (slot == link::StorageSlot::kMission ? "/mission.bin" : "/params.bin");
}

link::StorageResult Storage::write(const link::StorageRequest& request) {
  if (request.slot == link::StorageSlot::kNone) return {};
  if (!directory_.empty() && !replace_file(request.slot, request.bytes, request.size)) return {request.slot, false};
  (request.slot == link::StorageSlot::kMission ? mission_ : params_)
      .assign(request.bytes, request.bytes + request.size);
  return {request.slot, true};
}

bool Storage::replace_file(link::StorageSlot slot, const std::uint8_t* bytes, std::size_t size) const {
  const std::string final_path = path(slot), temporary = final_path + ".new";
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return false;
  const bool on_disk = write_all(file, bytes, size) && ::fsync(file) == 0;
  const bool closed = ::close(file) == 0;
  if (!on_disk || !closed || std::rename(temporary.c_str(), final_path.c_str()) != 0) return false;
  const int folder = ::open(directory_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);  // the new name, too
  if (folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
  return true;
}

}  // namespace halfroll::host

// A process of Python as a board. Why: the firmware in the module is the one that a notebook flies, and must give the
// bits of all others.
#include "bindings.hpp"
#include "boards/hil/hil_board.hpp"
#include "boards/host/byte_channel.hpp"
#include "boards/host/storage.hpp"

namespace halfroll::bindings {
namespace {

class ProcessHost final : public hil::Host {
 public:
  explicit ProcessHost(const std::string& directory) : storage_(directory) {}
  link::StoredImage stored(link::StorageSlot slot) override { return storage_.stored(slot); }
  link::StorageResult store(const link::StorageRequest& request) override { return storage_.write(request); }

 private:
  host::Storage storage_;
};

void serve_board(int in, int out, const std::string& storage) {
  host::ByteChannel channel(in, out);
  ProcessHost process(storage);
  hil::HilBoard board(channel, process);
  const auto room = std::make_unique<boards::Room>();
  boards::run(board, *room);
}

}  // namespace

void bind_board(py::module_& m) {
  m.def("serve_board", &serve_board, "in_fd"_a, "out_fd"_a, "storage"_a = "", py::call_guard<py::gil_scoped_release>(),
        "Fly as the board of a halfroll-sitl --board: its frames come and go by two file descriptors, until the other "
        "end is closed. storage: directory of what outlives the process.");
}

}  // namespace halfroll::bindings

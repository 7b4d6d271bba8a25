#include "boards/host/storage.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "boards/two_slots.hpp"

namespace halfroll::host {
namespace {

constexpr std::size_t kCapacity = std::size_t{128} * 1024;  // two pages of a large flash: more than any image needs

/// A region is a file; an erased one is empty.
class FileMedium final : public boards::Medium {
 public:
  /// Regions PATH.0.bin and PATH.1.bin, and who may use them.
  FileMedium(const std::string& path, mode_t mode) {
    for (int region = 0; region < 2; ++region) {
      const std::string name = path + (region == 0 ? ".0.bin" : ".1.bin");
      files_[region] = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, mode);
      if (files_[region] >= 0 && mode == 0600) ::fchmod(files_[region], mode);  // also one that was open before
    }
    const std::string folder = std::filesystem::path(path).parent_path().string();
    folder_ = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  }
  FileMedium(const FileMedium&) = delete;
  FileMedium& operator=(const FileMedium&) = delete;
  ~FileMedium() {
    for (const int file : {files_[0], files_[1], folder_}) {
      if (file >= 0) ::close(file);
    }
  }

  std::size_t capacity() const override { return kCapacity; }
  bool erase(int region) override { return ::ftruncate(files_[region], 0) == 0; }
  bool program(int region, std::size_t offset, const std::uint8_t* bytes, std::size_t size) override {
    while (size > 0) {
      const ssize_t written = ::pwrite(files_[region], bytes, size, static_cast<off_t>(offset));
      if (written <= 0) return false;
      bytes += written;
      offset += static_cast<std::size_t>(written);
      size -= static_cast<std::size_t>(written);
    }
    return true;
  }
  bool flush(int region) override { return ::fsync(files_[region]) == 0 && (folder_ < 0 || ::fsync(folder_) == 0); }
  std::size_t read(int region, std::size_t offset, std::uint8_t* bytes, std::size_t size) const override {
    std::size_t done = 0;
    while (done < size) {
      const ssize_t got = ::pread(files_[region], bytes + done, size - done, static_cast<off_t>(offset + done));
      if (got <= 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  int files_[2] = {-1, -1};
  int folder_ = -1;
};

std::size_t index(link::StorageSlot slot) { return static_cast<std::size_t>(slot); }

/// The signing key is its owner's alone.
mode_t access(link::StorageSlot slot) { return slot == link::StorageSlot::kSigning ? 0600 : 0644; }

}  // namespace

Storage::Storage(std::string directory) : directory_(std::move(directory)) {
  if (directory_.empty()) return;
  std::error_code failed;
  std::filesystem::create_directories(directory_, failed);
  if (!std::filesystem::is_directory(directory_)) {
    throw std::runtime_error("--storage " + directory_ + " is not a directory and cannot be made one");
  }
  for (const auto slot : {link::StorageSlot::kParams, link::StorageSlot::kMission, link::StorageSlot::kSigning}) {
    FileMedium medium(path(slot), access(slot));
    const boards::TwoSlots slots(medium);
    Kept& kept = kept_[index(slot)];
    kept.state = slots.state();
    kept.image.resize(slots.size());
    if (!slots.read(kept.image.data())) kept = {link::StoredState::kLost, {}};
  }
}

std::string Storage::path(link::StorageSlot slot) const {
  constexpr const char* kNames[link::kStorageSlotCount] = {"", "params", "mission", "signing"};
  return directory_ + "/" + kNames[index(slot)];
}

link::StoredImage Storage::stored(link::StorageSlot slot) const {
  const Kept& kept = kept_[index(slot)];
  return {kept.state, kept.image.data(), kept.image.size()};
}

link::StorageResult Storage::write(const link::StorageRequest& request) {
  if (request.slot == link::StorageSlot::kNone) return {};
  if (!directory_.empty()) {
    FileMedium medium(path(request.slot), access(request.slot));
    if (!boards::TwoSlots(medium).write(request.bytes, request.size)) return {request.slot, false};
  }
  kept_[index(request.slot)] = {link::StoredState::kSound, {request.bytes, request.bytes + request.size}};
  return {request.slot, true};
}

}  // namespace halfroll::host

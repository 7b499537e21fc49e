#include "bench/background_load.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <numeric>

#include "rt/process.hpp"

namespace servohil::bench {
namespace {

/// Each of the two buffers: beyond the second-level cache of any CPU, and a large part of the third's.
constexpr std::size_t kBufferBytes = std::size_t{8} << 20;
constexpr std::size_t kPieceBytes = std::size_t{256} << 10;

std::vector<int> AllowedCpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  std::vector<int> cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &set)) cpus.push_back(cpu);
  }
  return cpus;
}

void PinTo(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  sched_setaffinity(0, sizeof set, &set);
}

/// A file without a name, gone with its descriptor. Where there is no room for it, the disk stays idle.
class ScratchFile {
 public:
  ScratchFile() {
    std::error_code error;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
    if (!error) fd_ = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  }
  ~ScratchFile() {
    if (fd_ >= 0) close(fd_);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  /// The same piece of the file again and again, through to the device.
  void Write(const unsigned char* data, std::size_t bytes) const {
    if (fd_ < 0 || pwrite(fd_, data, bytes, 0) < 0) return;
    static_cast<void>(fdatasync(fd_));
  }

 private:
  int fd_ = -1;
};

void MapAndUnmap() {
  void* piece =
      mmap(nullptr, kPieceBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (piece != MAP_FAILED) munmap(piece, kPieceBytes);
}

void Disturb(const std::stop_token& stop, int cpu) {
  PinTo(cpu);
  rt::NameThread("load");
  const ScratchFile file;
  std::vector<unsigned char> from(kBufferBytes);
  std::vector<unsigned char> to(kBufferBytes);
  std::iota(from.begin(), from.end(), static_cast<unsigned char>(0));
  for (std::size_t round = 0; !stop.stop_requested(); ++round) {
    std::memcpy(to.data(), from.data(), kBufferBytes);
    std::swap(from, to);
    MapAndUnmap();
    sched_yield();
    constexpr std::size_t kRoundsPerWrite = 16;
    if (round % kRoundsPerWrite == 0) file.Write(from.data(), kPieceBytes);
  }
}

}  // namespace

BackgroundLoad::BackgroundLoad() {
  for (const int cpu : AllowedCpus())
    threads_.emplace_back([cpu](const std::stop_token& stop) { Disturb(stop, cpu); });
}

}  // namespace servohil::bench

#pragma once
/// What a busy machine does to a real-time loop, made on purpose: one thread per CPU, at normal priority,
/// that turns over the caches, maps and unmaps memory, switches context and writes to the disk.

#include <cstddef>
#include <stop_token>
#include <thread>
#include <vector>

namespace servohil::bench {

/// Runs while it exists; its threads and its (nameless) files end with it.
class BackgroundLoad {
 public:
  /// One thread on each CPU that this process may use: those isolated from other processes stay so.
  /// Constructed by a thread of normal priority, which they inherit.
  BackgroundLoad();
  std::size_t Threads() const noexcept { return threads_.size(); }

 private:
  std::vector<std::jthread> threads_;  ///< each is asked to stop and joined
};

}  // namespace servohil::bench

#pragma once
/// What mailbox and ring are made of. The tests put a memory in its place that a scheduler steps through
/// (tests/rt/interleaving.hpp).

#include <atomic>

namespace servohil::rt {

struct StandardMemory {
  template <typename T>
  using Atomic = std::atomic<T>;
  template <typename T>
  using Cell = T;  ///< what one side writes, and later the other reads
};

}  // namespace servohil::rt

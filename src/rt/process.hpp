#pragma once
/// What a process needs from Linux to be real-time: locked memory and FIFO scheduling on a CPU of its choice.

#include <string>
#include <vector>

namespace servohil::rt {

/// One thing that could not be had: what, why, and the command that grants it.
using Shortcomings = std::vector<std::string>;

/// Locks all present and future pages and makes the allocator keep what it has, so that no page fault comes
/// later.
Shortcomings LockMemory();

/// SCHED_FIFO at `priority` (1 to 99) for the calling thread; pinned to `cpu` unless that is negative.
Shortcomings MakeThreadRealTime(int priority, int cpu);

/// Touches the stack that the calling thread may use, so that it is mapped. Real-time threads call it first.
void PrefaultStack() noexcept;

/// Name of the calling thread as `top -H` and `ps -L` show it. @param name at most 15 characters
void NameThread(const char* name) noexcept;

/// Page faults of the calling thread so far, minor and major.
long ThreadPageFaults() noexcept;

}  // namespace servohil::rt

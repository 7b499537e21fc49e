#pragma once
/// A model checker for two threads: runs the real templates in every order in which their accesses to shared
/// memory can interleave.
///
/// The templates get SteppedMemory for StandardMemory: before each access to an atomic or a cell, control
/// goes to the explorer, which decides whose access comes next. A cell is accessed in two halves, so that a
/// value that is read while it is written shows as torn. The explorer runs the pair again and again, depth
/// first, until every order has been seen.
///
/// Two orders that differ only in neighbouring accesses that do not touch the same place (or only read it)
/// end in the same state; of those, one is run (sleep sets: P. Godefroid, Partial-Order Methods for the
/// Verification of Concurrent Systems, 1996, chapter 5).
///
/// The orders are sequentially consistent: a memory order that is too weak is not found here but by
/// ThreadSanitizer (channel_stress_test.cpp).

#include <ucontext.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace servohil::rt::testing {

/// What a thread is about to do.
struct Access {
  const void* place = nullptr;
  bool writes = false;
};

inline bool AreIndependent(const Access& a, const Access& b) {
  return a.place != b.place || (!a.writes && !b.writes);
}

/// What ThreadSanitizer has to be told of contexts that are switched by hand; nothing in other builds.
class SanitizerFiber {
 public:
#ifdef __SANITIZE_THREAD__
  SanitizerFiber() : fiber_(__tsan_create_fiber(0)) {}
  ~SanitizerFiber() {
    __tsan_destroy_fiber(fiber_);
  }
  void BeforeEntering() {
    explorer_ = __tsan_get_current_fiber();
    __tsan_switch_to_fiber(fiber_, 0);
  }
  void BeforeLeaving() {
    __tsan_switch_to_fiber(explorer_, 0);
  }
#else
  SanitizerFiber() = default;
  void BeforeEntering() {}
  void BeforeLeaving() {}
#endif
  SanitizerFiber(const SanitizerFiber&) = delete;
  SanitizerFiber& operator=(const SanitizerFiber&) = delete;

#ifdef __SANITIZE_THREAD__
 private:
  void* fiber_;
  void* explorer_ = nullptr;
#endif
};

/// A thread that runs when it is resumed, up to its next access: a context of its own on the one real thread.
class SteppedThread {
 public:
  SteppedThread() : stack_(kStackBytes) {
    getcontext(&context_);
    context_.uc_stack.ss_sp = stack_.data();
    context_.uc_stack.ss_size = stack_.size();
    makecontext(&context_, &RunBodies, 0);
  }
  SteppedThread(const SteppedThread&) = delete;
  SteppedThread& operator=(const SteppedThread&) = delete;

  /// Runs `body` up to its first access. The one before must have come to its end.
  void Start(std::function<void()> body) {
    body_ = std::move(body);
    finished_ = false;
    Resume();
  }
  /// Makes the access and goes on up to the next one, or to the end.
  void Resume() {
    running_ = this;
    fiber_.BeforeEntering();
    swapcontext(&explorer_, &context_);
    running_ = nullptr;
  }
  bool Finished() const { return finished_; }
  const Access& Next() const { return next_; }

  /// By the memory, before each access. Outside of an exploration it does nothing.
  static void AboutTo(const void* place, bool writes) {
    SteppedThread* self = running_;
    if (self == nullptr) return;
    self->next_ = {place, writes};
    self->Leave();
  }

 private:
  static constexpr std::size_t kStackBytes = std::size_t{64} * 1024;

  static void RunBodies() {
    for (SteppedThread* self = running_;;) {
      self->body_();
      self->finished_ = true;
      self->Leave();
    }
  }
  void Leave() {
    fiber_.BeforeLeaving();
    swapcontext(&context_, &explorer_);
  }

  inline static SteppedThread* running_ = nullptr;

  std::function<void()> body_;
  std::vector<char> stack_;
  SanitizerFiber fiber_;
  ucontext_t context_{};
  ucontext_t explorer_{};
  Access next_;
  bool finished_ = true;
};

struct SteppedMemory {
  /// As std::atomic, as far as mailbox and ring use it.
  template <typename T>
  class Atomic {
   public:
    Atomic(T value) : value_(value) {}
    T load(std::memory_order = std::memory_order_seq_cst) const noexcept {
      SteppedThread::AboutTo(this, false);
      return value_;
    }
    void store(T value, std::memory_order = std::memory_order_seq_cst) noexcept {
      SteppedThread::AboutTo(this, true);
      value_ = value;
    }
    T exchange(T value, std::memory_order = std::memory_order_seq_cst) noexcept {
      SteppedThread::AboutTo(this, true);
      return std::exchange(value_, value);
    }
    T fetch_add(T value, std::memory_order = std::memory_order_seq_cst) noexcept {
      SteppedThread::AboutTo(this, true);
      return std::exchange(value_, static_cast<T>(value_ + value));
    }

   private:
    T value_;
  };

  /// A value that takes two accesses to write or read.
  template <typename T>
  class Cell {
   public:
    Cell& operator=(const T& value) noexcept {
      std::array<char, sizeof(T)> bytes;
      std::memcpy(bytes.data(), &value, sizeof(T));
      for (const std::size_t half : {std::size_t{0}, kHalf}) {
        SteppedThread::AboutTo(&bytes_[half], true);
        std::memcpy(&bytes_[half], &bytes[half], half == 0 ? kHalf : sizeof(T) - kHalf);
      }
      return *this;
    }
    operator T() const noexcept {
      std::array<char, sizeof(T)> bytes;
      for (const std::size_t half : {std::size_t{0}, kHalf}) {
        SteppedThread::AboutTo(&bytes_[half], false);
        std::memcpy(&bytes[half], &bytes_[half], half == 0 ? kHalf : sizeof(T) - kHalf);
      }
      T value;
      std::memcpy(&value, bytes.data(), sizeof(T));
      return value;
    }

   private:
    static constexpr std::size_t kHalf = sizeof(T) / 2;
    static_assert(kHalf > 0, "one byte cannot be torn");
    std::array<char, sizeof(T)> bytes_{};
  };
};

struct Exploration {
  std::uint64_t orders = 0;  ///< run to their end and checked
  std::string fault;         ///< the first law broken; empty when all held
  std::string order;         ///< in which it broke: whose access each was, 'A' or 'B'
};

enum class Orders : std::uint8_t {
  kDistinct,  ///< one of those that end in the same state
  kAll
};

/// Depth-first search over the orders. System: default-constructed for each order; RunA() and RunB() are the
/// threads, whose only shared state is in SteppedMemory; Fault() tells, after both, which law broke.
template <typename System>
class Explorer {
 public:
  /// @param observe  sees the system at the end of each order
  Explorer(Orders orders, std::function<void(const System&)> observe)
      : orders_(orders), observe_(std::move(observe)) {}

  Exploration Run() {
    Exploration result;
    do {
      System system;
      if (!RunOnce(system)) continue;
      ++result.orders;
      result.fault = system.Fault();
      result.order = order_;
      observe_(system);
    } while (result.fault.empty() && Advance());
    return result;
  }

 private:
  using Threads = unsigned;  ///< a bit for each

  struct Choice {
    std::size_t chosen = 0;
    Threads enabled = 0;
    Threads asleep = 0;  ///< their next access has been tried before, and nothing since depends on it
    Threads tried = 0;
  };

  static std::size_t First(Threads threads) { return (threads & Bit(0)) != 0 ? 0 : 1; }
  static Threads Bit(std::size_t thread) { return 1U << thread; }

  /// @return false when it ends in a state that another order has reached
  bool RunOnce(System& system) {
    threads_[0].Start([&] { system.RunA(); });
    threads_[1].Start([&] { system.RunB(); });
    order_.clear();
    Threads asleep = 0;
    bool is_new = true;
    for (std::size_t depth = 0;; ++depth) {
      const Threads enabled = (threads_[0].Finished() ? 0U : Bit(0)) | (threads_[1].Finished() ? 0U : Bit(1));
      if (enabled == 0) return is_new;
      if (depth == path_.size()) {
        is_new = is_new && (enabled & ~asleep) != 0;
        if (is_new) path_.push_back({First(enabled & ~asleep), enabled, asleep, 0});
      }
      const std::size_t chosen = is_new ? path_[depth].chosen : First(enabled);
      if (is_new) asleep = StillAsleep(path_[depth], threads_[chosen], threads_[1 - chosen]);
      order_ += chosen == 0 ? 'A' : 'B';
      threads_[chosen].Resume();
    }
  }

  /// After the chosen access: the other thread, if it was asleep or tried, and its access is independent.
  Threads StillAsleep(const Choice& choice, const SteppedThread& chosen, const SteppedThread& other) const {
    if (orders_ == Orders::kAll || other.Finished() || !AreIndependent(chosen.Next(), other.Next())) return 0;
    return (choice.asleep | choice.tried) & ~Bit(choice.chosen);
  }

  /// To the next branch not taken. @return false when there is none
  bool Advance() {
    while (!path_.empty()) {
      Choice& last = path_.back();
      last.tried |= Bit(last.chosen);
      const Threads left = last.enabled & ~last.asleep & ~last.tried;
      if (left != 0) {
        last.chosen = First(left);
        return true;
      }
      path_.pop_back();
    }
    return false;
  }

  Orders orders_;
  std::function<void(const System&)> observe_;
  std::array<SteppedThread, 2> threads_;
  std::vector<Choice> path_;
  std::string order_;
};

template <typename System>
Exploration Explore(
    Orders orders = Orders::kDistinct, std::function<void(const System&)> observe = [](const System&) {}) {
  return Explorer<System>(orders, std::move(observe)).Run();
}

}  // namespace servohil::rt::testing

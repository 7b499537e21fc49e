#include "scenario/evaluator.hpp"

#include <chrono>
#include <utility>

#include "rt/process.hpp"

namespace servohil::scenario {

Evaluator::Evaluator(const Scenario& scenario, bool producer_waits)
    : feed_(producer_waits), evaluation_(scenario), thread_([this] { Run(); }) {}

Evaluator::~Evaluator() {
  End();
}

void Evaluator::Run() {
  constexpr std::chrono::milliseconds kRest{5};  // the feed has room for 3 s
  rt::NameThread("scenario");
  while (!stop_.load()) {
    TakeAll();
    std::this_thread::sleep_for(kRest);
  }
}

void Evaluator::TakeAll() {
  simulation::RunState now;
  while (feed_.TryPop(now)) evaluation_.Take(now);
}

void Evaluator::End() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

Verdict Evaluator::Judge(std::vector<std::string> invalid_because) {
  End();
  TakeAll();
  return evaluation_.Judge(std::move(invalid_because));
}

}  // namespace servohil::scenario

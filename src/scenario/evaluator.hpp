#pragma once
/// Evaluates a run beside its simulation thread, which only puts each tick's state into a feed.

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "scenario/evaluation.hpp"
#include "simulation/sample_feed.hpp"

namespace servohil::scenario {

class Evaluator {
 public:
  /// @param scenario  must outlive it; @param producer_waits  as of SampleFeed
  Evaluator(const Scenario& scenario, bool producer_waits);
  ~Evaluator();
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  /// For the simulation.
  simulation::SampleFeed& Feed() { return feed_; }

  /// After the simulation has ended. @param invalid_because  as of Evaluation::Judge
  Verdict Judge(std::vector<std::string> invalid_because);

 private:
  void Run();
  void TakeAll();
  void End();

  simulation::SampleFeed feed_;
  Evaluation evaluation_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace servohil::scenario

#include "fault_words/permissions.hpp"

#include <utility>

#include "base/error.hpp"

namespace servohil::fault_words {

PermittedInjection RequestInjection(const std::string& fault, const Words& words,
                                    const Permissions& permissions) {
  RequireFault(fault);
  if (!permissions.armed) throw base::UsageError(permissions.why_not_armed);
  UnderstoodInjection understood = UnderstandInjection(fault, words, permissions.faults);
  PermittedInjection permitted;
  permitted.request.kind = simulation::Request::Kind::kInject;
  permitted.request.injection = understood.injection;
  permitted.warning = std::move(understood.warning);
  return permitted;
}

simulation::Request RequestClear(const std::optional<std::string>& fault, const Words& words,
                                 const Permissions& permissions) {
  simulation::Request request;
  request.kind = simulation::Request::Kind::kClearAll;
  if (!fault) return request;
  const fault::Spec& spec = RequireFault(*fault);
  request.kind = simulation::Request::Kind::kClear;
  request.injection.id = spec.id;
  request.injection.target = UnderstandTarget(spec, words, permissions.faults);
  return request;
}

}  // namespace servohil::fault_words

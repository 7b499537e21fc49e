#include "permissions.hpp"

#include <utility>

#include "servohil/error.hpp"

namespace servohil::app {

PermittedInjection RequestInjection(const std::string& fault, const Words& words, const Permissions& permissions) {
  RequireFault(fault);
  if (!permissions.armed) throw UsageError(permissions.why_not_armed);
  UnderstoodInjection understood = UnderstandInjection(fault, words, permissions.faults);
  PermittedInjection permitted;
  permitted.request.kind = Request::Kind::kInject;
  permitted.request.injection = understood.injection;
  permitted.warning = std::move(understood.warning);
  return permitted;
}

Request RequestClear(const std::optional<std::string>& fault, const Words& words, const Permissions& permissions) {
  Request request;
  request.kind = Request::Kind::kClearAll;
  if (!fault) return request;
  const fault::Spec& spec = RequireFault(*fault);
  request.kind = Request::Kind::kClear;
  request.injection.id = spec.id;
  request.injection.target = UnderstandTarget(spec, words, permissions.faults);
  return request;
}

}  // namespace servohil::app

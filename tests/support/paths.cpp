#include "paths.hpp"

namespace servohil::testing {

std::string SourceFile(const std::string& file) {
  return std::string(SERVOHIL_SOURCE_DIR "/") + file;
}

}  // namespace servohil::testing

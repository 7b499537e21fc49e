// Any bytes as a configuration file: read, or refused with one line.

#include "fuzz.hpp"
#include "servohil/app/configuration.hpp"

int FuzzOne(std::string_view text) {
  if (text.find("/") != std::string_view::npos)
    return -1;  // no other file of this machine, such as /dev/zero
  RequireReadableErrors(
      [&] { servohil::app::ParseConfiguration(text, SERVOHIL_CONFIG_DIR "/fuzz.toml", {}); });
  return 0;
}

#pragma once
/// What the kernel knows of a CAN interface, in short; link.hpp has the rest.

#include <cstdint>
#include <optional>
#include <string>

namespace servohil::can {

/// The kernel has an interface of this name and it is a CAN interface.
bool IsCanInterface(const std::string& name) noexcept;

/// vcan or vxcan. What slcand makes is physical, though the kernel calls it virtual.
bool IsVirtualInterface(const std::string& interface);

/// The interface exists and is up.
bool IsInterfaceUp(const std::string& name) noexcept;

/// The serial device is a pseudo-terminal: another program plays the adapter.
bool IsTerminalOfAProgram(const std::string& device) noexcept;

/// Nominal bit rate of a real interface that is up; nothing for a virtual one (it has none).
std::optional<std::uint32_t> InterfaceBitRate(const std::string& name);

/// For people: "up, 500000 bit/s, error-active", "up, virtual", "down", "gone".
std::string DescribeInterface(const std::string& name);

}  // namespace servohil::can

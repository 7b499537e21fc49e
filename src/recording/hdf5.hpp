#pragma once
/// The HDF5 C library with owned identifiers and errors as one line.

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <utility>

namespace servohil::recording {

/// Each thread calls it before its first call of the library: nothing is printed to standard error, and the
/// library does not close at the program's end what could not be closed before.
void PrepareThread() noexcept;

/// An identifier of any kind; negative: none.
class Id {
 public:
  Id() = default;
  explicit Id(hid_t id) noexcept : id_(id) {}
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Id& operator=(Id&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Id() { Close(); }

  hid_t operator*() const noexcept { return id_; }
  explicit operator bool() const noexcept { return id_ >= 0; }
  /// @return false when what was left to write could not be written
  bool Close() noexcept {
    const hid_t id = std::exchange(id_, H5I_INVALID_HID);
    return id < 0 || H5Idec_ref(id) >= 0;
  }
  /// Left open until the program ends.
  void Abandon() noexcept { id_ = H5I_INVALID_HID; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

/// Why the last call failed, from the innermost function: "No space left on device". Forgets it.
std::string LastError();

/// @param what  "FILE: samples/x3_in cannot be written"
/// @throws EnvironmentError `what` and why, when `result` is negative
void Require(herr_t result, const std::string& what);
Id Require(Id id, const std::string& what);

void WriteAttribute(hid_t object, const char* name, const std::string& text, const std::string& file);
void WriteAttribute(hid_t object, const char* name, std::uint64_t number, const std::string& file);
void WriteAttribute(hid_t object, const char* name, double number, const std::string& file);

bool HasAttribute(hid_t object, const char* name) noexcept;
/// @throws UsageError when it is missing or of another type
std::string ReadText(hid_t object, const char* name, const std::string& file);
std::uint64_t ReadNumber(hid_t object, const char* name, const std::string& file);

}  // namespace servohil::recording

#include "recording/hdf5.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "base/error.hpp"

namespace servohil::recording {
namespace {

/// Text of a length of its own. Not variable-length strings: those live in the file's global heap, which has
/// no checksum, and the library crashes where it is damaged.
Id TextType(std::size_t size_bytes) {
  Id type(H5Tcopy(H5T_C_S1));
  H5Tset_size(*type, size_bytes);
  H5Tset_strpad(*type, H5T_STR_NULLPAD);
  H5Tset_cset(*type, H5T_CSET_UTF8);
  return type;
}

void WriteScalar(hid_t object, const char* name, hid_t file_type, hid_t memory_type, const void* value,
                 const std::string& file) {
  const std::string what = file + ": attribute " + name + " cannot be written";
  const Id space(H5Screate(H5S_SCALAR));
  const Id attribute =
      Require(Id(H5Acreate2(object, name, file_type, *space, H5P_DEFAULT, H5P_DEFAULT)), what);
  Require(H5Awrite(*attribute, memory_type, value), what);
}

Id OpenScalar(hid_t object, const char* name, H5T_class_t kind, const std::string& file) {
  if (H5Aexists(object, name) == 0) throw base::UsageError(file + ": attribute " + name + " is missing");
  Id attribute(H5Aopen(object, name, H5P_DEFAULT));
  if (!attribute) throw base::UsageError(file + ": attribute " + name + " is damaged: " + LastError());
  const Id type(H5Aget_type(*attribute));
  const Id space(H5Aget_space(*attribute));
  const bool text = H5Tget_class(*type) == H5T_STRING && H5Tis_variable_str(*type) == 0;
  const bool fits = kind == H5T_STRING ? text : H5Tget_class(*type) == kind;
  if (!fits || H5Sget_simple_extent_npoints(*space) != 1) {
    throw base::UsageError(file + ": attribute " + name + " is no " +
                           (kind == H5T_STRING ? "text" : "whole number"));
  }
  return attribute;
}

}  // namespace

void PrepareThread() noexcept {
  static const bool once = [] {
    H5dont_atexit();
    return true;
  }();
  static_cast<void>(once);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string LastError() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* error, void* out) -> herr_t {
        if (n == 0 && error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
        return 0;
      },
      &text);
  H5Eclear2(H5E_DEFAULT);  // else lost with the thread
  // The POSIX driver's description is a list; what the system said is in it.
  constexpr std::string_view kMark = "error message = '";
  if (const std::size_t at = text.find(kMark); at != std::string::npos) {
    text = text.substr(at + kMark.size());
    text = text.substr(0, text.find('\''));
  }
  return text.empty() ? "no reason given" : text;
}

void Require(herr_t result, const std::string& what) {
  if (result < 0) throw base::EnvironmentError(what + ": " + LastError());
}

Id Require(Id id, const std::string& what) {
  if (!id) throw base::EnvironmentError(what + ": " + LastError());
  return id;
}

void WriteAttribute(hid_t object, const char* name, const std::string& text, const std::string& file) {
  const Id type = TextType(std::max<std::size_t>(text.size(), 1));  // empty: one zero byte of padding
  WriteScalar(object, name, *type, *type, text.c_str(), file);
}

void WriteAttribute(hid_t object, const char* name, std::uint64_t number, const std::string& file) {
  WriteScalar(object, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, &number, file);
}

void WriteAttribute(hid_t object, const char* name, double number, const std::string& file) {
  WriteScalar(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &number, file);
}

bool HasAttribute(hid_t object, const char* name) noexcept {
  return H5Aexists(object, name) > 0;
}

std::string ReadText(hid_t object, const char* name, const std::string& file) {
  const Id attribute = OpenScalar(object, name, H5T_STRING, file);
  const Id type(H5Aget_type(*attribute));
  std::string text(H5Tget_size(*type), '\0');
  if (H5Aread(*attribute, *type, text.data()) < 0)
    throw base::UsageError(file + ": attribute " + name + " is damaged: " + LastError());
  text.resize(text.find_last_not_of('\0') + 1);
  return text;
}

std::uint64_t ReadNumber(hid_t object, const char* name, const std::string& file) {
  const Id attribute = OpenScalar(object, name, H5T_INTEGER, file);
  std::uint64_t number = 0;
  if (H5Aread(*attribute, H5T_NATIVE_UINT64, &number) < 0) {
    throw base::UsageError(file + ": attribute " + name + " is damaged: " + LastError());
  }
  return number;
}

}  // namespace servohil::recording

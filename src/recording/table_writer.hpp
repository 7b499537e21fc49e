#pragma once
/// A group of equally long one-dimensional datasets that grows by rows.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "recording/hdf5.hpp"

namespace servohil::recording {

/// How a column's chunks are stored. All have a checksum (Fletcher-32).
enum class Packing : std::uint8_t { kDeflated, kAsIs };

struct TableColumn {
  enum class Type : std::uint8_t { kDouble, kUnsigned64, kSigned64, kSigned32, kByte };

  std::string name;
  std::string unit;
  std::string description;
  Type type = Type::kDouble;
  Packing packing = Packing::kDeflated;
};

template <typename T>
constexpr TableColumn::Type ColumnTypeOf() {
  if constexpr (std::is_same_v<T, double>) return TableColumn::Type::kDouble;
  if constexpr (std::is_same_v<T, std::uint64_t>) return TableColumn::Type::kUnsigned64;
  if constexpr (std::is_same_v<T, std::int64_t>) return TableColumn::Type::kSigned64;
  if constexpr (std::is_same_v<T, int>) return TableColumn::Type::kSigned32;
  if constexpr (std::is_same_v<T, std::uint8_t>) return TableColumn::Type::kByte;
}

/// Errors of the library are EnvironmentErrors.
class TableWriter {
 public:
  /// @param parent  a file or group, `group` a path below it whose last part is new
  TableWriter(hid_t parent, const std::string& group, const std::vector<TableColumn>& columns,
              std::size_t chunk_rows, const std::string& file);

  /// The next value of a column; one of each, then EndRow(). @pre T is of the column's type
  template <typename T>
  void Put(std::size_t column, T value) {
    std::vector<std::byte>& pending = columns_[column].pending;
    const std::size_t at = pending.size();
    pending.resize(at + sizeof value);
    std::memcpy(&pending[at], &value, sizeof value);
  }
  void EndRow(std::int64_t now_ns) {
    if (pending_rows_++ == 0) oldest_ns_ = now_ns;
  }

  /// The pending rows fill a chunk: time to Write(), each chunk is then packed once.
  bool ChunkIsFull() const noexcept {
    return (rows_ + pending_rows_) % chunk_rows_ == 0 && pending_rows_ > 0;
  }
  bool HasRowsOlderThan(std::int64_t age_ns, std::int64_t now_ns) const noexcept {
    return HasPendingRows() && now_ns - oldest_ns_ >= age_ns;
  }

  /// Pending rows into the library. After an error the table is of no more use.
  void Write();
  /// From the library to the system.
  void Flush();

  /// What is not with the system yet is given up.
  void Abandon() noexcept {
    for (Column& column : columns_) column.dataset.Abandon();
  }

  std::uint64_t Rows() const noexcept { return rows_; }
  bool HasPendingRows() const noexcept { return pending_rows_ > 0; }

 private:
  struct Column {
    std::string place;  ///< "FILE: samples/x3_in", for errors
    Id dataset;
    hid_t memory_type;
    std::vector<std::byte> pending;
  };

  std::vector<Column> columns_;
  std::size_t chunk_rows_;
  std::uint64_t rows_ = 0;
  std::size_t pending_rows_ = 0;
  std::int64_t oldest_ns_ = 0;
};

}  // namespace servohil::recording

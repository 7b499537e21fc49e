#include "recording/table_writer.hpp"

#include <utility>

namespace servohil::recording {
namespace {

constexpr unsigned kFastestDeflate = 1;

struct Types {
  hid_t file;
  hid_t memory;
};

Types TypesOf(TableColumn::Type type) {
  switch (type) {
    case TableColumn::Type::kDouble:
      return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
    case TableColumn::Type::kUnsigned64:
      return {H5T_STD_U64LE, H5T_NATIVE_UINT64};
    case TableColumn::Type::kSigned64:
      return {H5T_STD_I64LE, H5T_NATIVE_INT64};
    case TableColumn::Type::kSigned32:
      return {H5T_STD_I32LE, H5T_NATIVE_INT32};
    case TableColumn::Type::kByte:
      break;
  }
  return {H5T_STD_U8LE, H5T_NATIVE_UINT8};
}

Id CreationProperties(Packing packing, hsize_t chunk_rows) {
  Id properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_chunk(*properties, 1, &chunk_rows);
  if (packing == Packing::kDeflated) {
    H5Pset_shuffle(*properties);
    H5Pset_deflate(*properties, kFastestDeflate);
  }
  H5Pset_fletcher32(*properties);
  return properties;
}

}  // namespace

TableWriter::TableWriter(hid_t parent, const std::string& group, const std::vector<TableColumn>& columns,
                         std::size_t chunk_rows, const std::string& file)
    : chunk_rows_(chunk_rows) {
  const Id links(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(*links, 1);
  const Id node =
      Require(Id(H5Gcreate2(parent, group.c_str(), *links, H5P_DEFAULT, H5P_DEFAULT)), file + ": " + group);
  constexpr hsize_t kNone = 0;
  constexpr hsize_t kUnlimited = H5S_UNLIMITED;
  const Id space(H5Screate_simple(1, &kNone, &kUnlimited));
  for (const TableColumn& column : columns) {
    const Types types = TypesOf(column.type);
    Column& made = columns_.emplace_back();
    made.place = file + ": " + group + "/" + column.name;
    made.memory_type = types.memory;
    made.dataset = Require(Id(H5Dcreate2(*node, column.name.c_str(), types.file, *space, H5P_DEFAULT,
                                         *CreationProperties(column.packing, chunk_rows), H5P_DEFAULT)),
                           made.place + " cannot be created");
    WriteAttribute(*made.dataset, "unit", column.unit, made.place);
    WriteAttribute(*made.dataset, "description", column.description, made.place);
  }
}

void TableWriter::Write() {
  const std::size_t rows = std::exchange(pending_rows_, 0);
  if (rows == 0) return;
  for (Column& column : columns_) {
    const hsize_t first = rows_;
    const hsize_t count = rows;
    const hsize_t total = first + count;
    Require(H5Dset_extent(*column.dataset, &total), column.place + " cannot be extended");
    const Id target(H5Dget_space(*column.dataset));
    const Id source(H5Screate_simple(1, &count, nullptr));
    H5Sselect_hyperslab(*target, H5S_SELECT_SET, &first, nullptr, &count, nullptr);
    Require(
        H5Dwrite(*column.dataset, column.memory_type, *source, *target, H5P_DEFAULT, column.pending.data()),
        column.place + " cannot be written");
    column.pending.clear();
  }
  rows_ += rows;
}

void TableWriter::Flush() {
  for (const Column& column : columns_)
    Require(H5Dflush(*column.dataset), column.place + " cannot be written");
}

}  // namespace servohil::recording

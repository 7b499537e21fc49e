#include "configuration/publish_toml.hpp"

#include <algorithm>
#include <array>

#include "base/error.hpp"
#include "base/nearest_name.hpp"
#include "configuration/toml_text.hpp"

namespace servohil::configuration {
namespace {

constexpr std::int64_t kLongestCycleMs = 10'000;
constexpr int kLargestDataId = 65'535;

/// The keys of one table, each taken once; what is left over is unknown.
class Table {
 public:
  Table(const toml::table& table, std::string name, const PlaceOfNode& place)
      : table_(table), name_(std::move(name)), place_(place) {}

  const toml::node* Take(const char* key) {
    known_.emplace_back(key);
    return table_.get(key);
  }
  std::string Text(const char* key) {
    const toml::node* const node = Take(key);
    if (node == nullptr) return {};
    const auto text = node->value_exact<std::string>();
    if (!text || text->empty()) Fail(key, *node, "must be a text in quotes");
    return *text;
  }
  bool Flag(const char* key) {
    const toml::node* const node = Take(key);
    if (node == nullptr) return false;
    const auto flag = node->value_exact<bool>();
    if (!flag) Fail(key, *node, "must be true or false");
    return *flag;
  }
  int Number(const char* key, int preset, int most) {
    const toml::node* const node = Take(key);
    if (node == nullptr) return preset;
    const auto value = node->value_exact<std::int64_t>();
    if (!value || *value < 0 || *value > most)
      Fail(key, *node, "must be a whole number from 0 to " + std::to_string(most));
    return static_cast<int>(*value);
  }
  template <typename Enum>
  Enum Choice(const char* key, Enum preset) {
    const std::string text = Text(key);
    if (text.empty()) return preset;
    const auto names = NamesOf(preset);
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (text == names[i]) return static_cast<Enum>(i);
      all += (all.empty() ? "" : ", ") + std::string(names[i]);
    }
    Fail(key, *table_.get(key), "must be one of " + all);
  }
  void RefuseOthers() const {
    for (const auto& [key, node] : table_) {
      const std::string text(key.str());
      if (std::find(known_.begin(), known_.end(), text) != known_.end()) continue;
      throw base::UsageError(place_(node) + ": unknown key " + name_ + "." + text + "; " +
                             base::DidYouMean(text, known_, "there are " + base::Listed(known_)));
    }
  }
  [[noreturn]] void Fail(const std::string& key, const toml::node& node, const std::string& right) const {
    throw base::UsageError(place_(node) + ": " + name_ + "." + key + " = " + Shown(node) + ": " + right);
  }

 private:
  const toml::table& table_;
  std::string name_;
  const PlaceOfNode& place_;
  std::vector<std::string> known_;
};

SignalSettings ReadSignalTable(const toml::table& node, SignalSettings settings, const std::string& name,
                               const PlaceOfNode& place) {
  Table table(node, name, place);
  settings.quantity = table.Text("quantity");
  settings.unit = table.Text("unit");
  settings.may_clip = table.Flag("may_clip");
  if (const toml::node* const scale = table.Take("scale"))
    settings.scale = ReadScale(*scale, name + ".scale", place);
  if (const toml::node* const raw = table.Take("raw")) {
    const auto value = raw->value_exact<std::int64_t>();
    if (!value) table.Fail("raw", *raw, "must be a whole number");
    settings.raw = *value;
  }
  table.RefuseOthers();
  if (settings.quantity.empty() == !settings.raw)
    throw base::UsageError(settings.place + ": " + name + " must have `quantity`, or `raw` for a constant");
  if (!settings.scale.empty() && !settings.unit.empty())
    throw base::UsageError(settings.place + ": " + name + " has both unit and scale: give one of them");
  return settings;
}

/// SIGNAL = "quantity", SIGNAL = 5.0 (constant) or SIGNAL = { quantity = ..., unit = ..., ... }
SignalSettings ReadSignal(const std::string& signal, const toml::node& node, const std::string& message,
                          const PlaceOfNode& place) {
  const std::string name = message + "." + signal;
  SignalSettings settings;
  settings.signal = signal;
  settings.place = place(node);
  if (const toml::table* const table = node.as_table()) return ReadSignalTable(*table, settings, name, place);
  if (const auto quantity = node.value_exact<std::string>()) {
    settings.quantity = *quantity;
  } else if (node.is_floating_point() || node.is_integer()) {
    settings.constant = node.value<double>();
  }
  if (settings.quantity.empty() && !settings.constant) {
    throw base::UsageError(settings.place + ": " + name + " = " + Shown(node) +
                           ": must be a quantity in quotes, a number, or { quantity = ..., unit = ... }");
  }
  return settings;
}

MessageSettings ReadMessage(const toml::table& node, const PlaceOfNode& place) {
  MessageSettings settings;
  settings.place = place(node);
  Table table(node, "can.publish", place);
  settings.message = table.Text("message");
  if (settings.message.empty())
    throw base::UsageError(settings.place + ": can.publish: `message` is missing");
  settings.on_change = table.Flag("on_change");
  settings.protection.profile = table.Choice("e2e", can::E2eProfile::kNone);
  settings.protection.data_id = table.Number("data_id", can::kNoDataId, kLargestDataId);
  settings.protection.data_id_mode = table.Choice("data_id_mode", can::DataIdMode::kBoth);
  settings.protection.counter = table.Text("counter");
  settings.protection.checksum = table.Text("checksum");
  if (const toml::node* const cycle = table.Take("cycle_ms")) {
    const auto value = cycle->value_exact<std::int64_t>();
    if (!value || *value < 1 || *value > kLongestCycleMs)
      table.Fail("cycle_ms", *cycle,
                 "must be a whole number from 1 to " + std::to_string(kLongestCycleMs) + " ms");
    settings.cycle_ms = static_cast<int>(*value);
  }
  if (const toml::node* const signals = table.Take("signals")) {
    if (!signals->is_table())
      table.Fail("signals", *signals, "must be a table: { SIGNAL = \"quantity\", ... }");
    for (const auto& [name, value] : *signals->as_table())
      settings.signals.push_back(ReadSignal(std::string(name.str()), value, settings.message, place));
  }
  table.RefuseOthers();
  return settings;
}

}  // namespace

Scale ReadScale(const toml::node& node, const std::string& key, const PlaceOfNode& place) {
  Scale scale;
  const auto fail = [&] {
    throw base::UsageError(place(node) + ": " + key + " = " + Shown(node) +
                           ": must be two points, as [[4.0, 0.0], [20.0, 150.0]]");
  };
  const toml::array* const points = node.as_array();
  if (points == nullptr) fail();
  for (const toml::node& point : *points) {
    const toml::array* const pair = point.as_array();
    if (pair == nullptr || pair->size() != 2 || !(*pair)[0].is_number() || !(*pair)[1].is_number()) fail();
    scale.push_back({*(*pair)[0].value<double>(), *(*pair)[1].value<double>()});
  }
  return scale;
}

std::vector<MessageSettings> ReadPublished(const toml::node& node, const PlaceOfNode& place) {
  const toml::array* const messages = node.as_array();
  std::vector<MessageSettings> published;
  if (messages == nullptr)
    throw base::UsageError(place(node) + ": can.publish must be a list of tables: [[can.publish]]");
  for (const toml::node& message : *messages) {
    if (!message.is_table())
      throw base::UsageError(place(message) + ": can.publish = " + Shown(message) +
                             ": must be a table: [[can.publish]]");
    published.push_back(ReadMessage(*message.as_table(), place));
  }
  return published;
}

}  // namespace servohil::configuration

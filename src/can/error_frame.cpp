#include "can/error_frame.hpp"

#include <linux/can/error.h>

#include <algorithm>
#include <span>

namespace servohil::can {
namespace {

struct Word {
  std::uint32_t bits;
  const char* text;
};

constexpr std::array kClasses = std::to_array<Word>({{CAN_ERR_TX_TIMEOUT, "tx-timeout"},
                                                     {CAN_ERR_LOSTARB, "lost-arbitration"},
                                                     {CAN_ERR_CRTL, "controller-problem"},
                                                     {CAN_ERR_PROT, "protocol-violation"},
                                                     {CAN_ERR_TRX, "transceiver-status"},
                                                     {CAN_ERR_ACK, "no-acknowledgement"},
                                                     {CAN_ERR_BUSOFF, "bus-off"},
                                                     {CAN_ERR_BUSERROR, "bus-error"},
                                                     {CAN_ERR_RESTARTED, "restarted"}});
constexpr std::array kController = std::to_array<Word>({{CAN_ERR_CRTL_RX_OVERFLOW, "rx-overflow"},
                                                        {CAN_ERR_CRTL_TX_OVERFLOW, "tx-overflow"},
                                                        {CAN_ERR_CRTL_RX_WARNING, "rx-error-warning"},
                                                        {CAN_ERR_CRTL_TX_WARNING, "tx-error-warning"},
                                                        {CAN_ERR_CRTL_RX_PASSIVE, "rx-error-passive"},
                                                        {CAN_ERR_CRTL_TX_PASSIVE, "tx-error-passive"},
                                                        {CAN_ERR_CRTL_ACTIVE, "back-to-error-active"}});
constexpr std::array kProtocol = std::to_array<Word>({{CAN_ERR_PROT_BIT, "single-bit"},
                                                      {CAN_ERR_PROT_FORM, "frame-format"},
                                                      {CAN_ERR_PROT_STUFF, "bit-stuffing"},
                                                      {CAN_ERR_PROT_BIT0, "dominant-bit"},
                                                      {CAN_ERR_PROT_BIT1, "recessive-bit"},
                                                      {CAN_ERR_PROT_OVERLOAD, "bus-overload"},
                                                      {CAN_ERR_PROT_ACTIVE, "active-error"},
                                                      {CAN_ERR_PROT_TX, "on-transmission"}});
/// One value, not bits.
constexpr std::array kLocation = std::to_array<Word>({{CAN_ERR_PROT_LOC_SOF, "start-of-frame"},
                                                      {CAN_ERR_PROT_LOC_ID28_21, "id-28-21"},
                                                      {CAN_ERR_PROT_LOC_ID20_18, "id-20-18"},
                                                      {CAN_ERR_PROT_LOC_SRTR, "srtr"},
                                                      {CAN_ERR_PROT_LOC_IDE, "ide"},
                                                      {CAN_ERR_PROT_LOC_ID17_13, "id-17-13"},
                                                      {CAN_ERR_PROT_LOC_ID12_05, "id-12-5"},
                                                      {CAN_ERR_PROT_LOC_ID04_00, "id-4-0"},
                                                      {CAN_ERR_PROT_LOC_RTR, "rtr"},
                                                      {CAN_ERR_PROT_LOC_RES1, "reserved-1"},
                                                      {CAN_ERR_PROT_LOC_RES0, "reserved-0"},
                                                      {CAN_ERR_PROT_LOC_DLC, "length-code"},
                                                      {CAN_ERR_PROT_LOC_DATA, "data"},
                                                      {CAN_ERR_PROT_LOC_CRC_SEQ, "crc"},
                                                      {CAN_ERR_PROT_LOC_CRC_DEL, "crc-delimiter"},
                                                      {CAN_ERR_PROT_LOC_ACK, "ack-slot"},
                                                      {CAN_ERR_PROT_LOC_ACK_DEL, "ack-delimiter"},
                                                      {CAN_ERR_PROT_LOC_EOF, "end-of-frame"},
                                                      {CAN_ERR_PROT_LOC_INTERM, "intermission"}});

// Bytes of an error frame.
constexpr std::size_t kControllerAt = 1;
constexpr std::size_t kProtocolAt = 2;
constexpr std::size_t kLocationAt = 3;
constexpr std::size_t kTxErrorsAt = 6;
constexpr std::size_t kRxErrorsAt = 7;

std::string Names(std::span<const Word> words, std::uint32_t bits) {
  std::string text;
  for (const Word& word : words) {
    if ((bits & word.bits) != 0) text += (text.empty() ? "" : ", ") + std::string(word.text);
  }
  return text;
}

std::string Braced(const std::string& text) {
  return text.empty() ? text : "{" + text + "}";
}

std::string LocationName(std::uint8_t location) {
  const auto* const found = std::find_if(kLocation.begin(), kLocation.end(),
                                         [&](const Word& word) { return word.bits == location; });
  return found == kLocation.end() ? std::string() : found->text;
}

std::string Details(std::uint32_t error_class, const std::array<std::uint8_t, 8>& data) {
  if (error_class == CAN_ERR_CRTL) return Braced(Names(kController, data[kControllerAt]));
  if (error_class == CAN_ERR_PROT)
    return Braced(Names(kProtocol, data[kProtocolAt])) + Braced(LocationName(data[kLocationAt]));
  if (error_class == CAN_ERR_LOSTARB && data[0] != CAN_ERR_LOSTARB_UNSPEC)
    return Braced("at bit " + std::to_string(data[0]));
  return {};
}

}  // namespace

void ErrorTotals::Take(const Frame& error) noexcept {
  const auto has = [&](std::uint32_t error_class) { return (error.id & error_class) != 0; };
  ++frames;
  last_classes = error.id;
  std::copy_n(error.data.begin(), last_data.size(), last_data.begin());

  const unsigned controller = has(CAN_ERR_CRTL) ? last_data[kControllerAt] : 0U;
  const bool acknowledge =
      has(CAN_ERR_ACK) || (has(CAN_ERR_PROT) && last_data[kLocationAt] == CAN_ERR_PROT_LOC_ACK);
  if (acknowledge) {
    ++missing_acknowledgements;
  } else if (has(CAN_ERR_PROT) || has(CAN_ERR_BUSERROR)) {
    ++disturbances;
  }
  if ((controller & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0) ++controller_overflows;
  if (has(CAN_ERR_BUSOFF)) ++bus_offs;
  if (has(CAN_ERR_RESTARTED)) ++restarts;

  if (has(CAN_ERR_BUSOFF)) {
    state = ControllerState::kBusOff;
  } else if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
    state = ControllerState::kErrorPassive;
  } else if ((controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) {
    state = ControllerState::kErrorWarning;
  } else if ((controller & CAN_ERR_CRTL_ACTIVE) != 0 || has(CAN_ERR_RESTARTED)) {
    state = ControllerState::kErrorActive;
  }
  // Older drivers fill the counters without saying so.
  if (has(CAN_ERR_CNT) || last_data[kTxErrorsAt] != 0 || last_data[kRxErrorsAt] != 0) {
    tx_errors = last_data[kTxErrorsAt];
    rx_errors = last_data[kRxErrorsAt];
  }
}

std::string ErrorTotals::DescribeLast() const {
  std::string text;
  for (const Word& word : kClasses) {
    if ((last_classes & word.bits) == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(word.text) + Details(word.bits, last_data);
  }
  return text;
}

}  // namespace servohil::can

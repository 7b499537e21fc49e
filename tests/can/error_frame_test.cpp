#include "can/error_frame.hpp"

#include <gtest/gtest.h>
#include <linux/can/error.h>

namespace servohil::can {
namespace {

Frame Error(std::uint32_t classes, std::array<std::uint8_t, 8> data = {}) {
  Frame frame;
  frame.error = true;
  frame.id = classes;
  frame.size = 8;
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

TEST(ErrorTotals, FollowTheControllersState) {
  ErrorTotals totals;
  totals.Take(Error(CAN_ERR_CRTL | CAN_ERR_CNT, {0, CAN_ERR_CRTL_TX_WARNING, 0, 0, 0, 0, 100, 3}));
  EXPECT_EQ(totals.state, ControllerState::kErrorWarning);
  EXPECT_EQ(totals.tx_errors, 100);
  EXPECT_EQ(totals.rx_errors, 3);
  totals.Take(Error(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_WARNING}));
  EXPECT_EQ(totals.state, ControllerState::kErrorPassive) << "the worse of both directions";
  EXPECT_EQ(totals.tx_errors, 100) << "nothing was told of the counters";
  totals.Take(Error(CAN_ERR_BUSOFF));
  EXPECT_EQ(totals.state, ControllerState::kBusOff);
  totals.Take(Error(CAN_ERR_RESTARTED | CAN_ERR_CNT));
  EXPECT_EQ(totals.state, ControllerState::kErrorActive);
  EXPECT_EQ(totals.tx_errors, 0);
  totals.Take(Error(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_OVERFLOW}));
  EXPECT_EQ(totals.state, ControllerState::kErrorActive) << "an overflow is no error state";
  EXPECT_EQ(totals.frames, 5U);
  EXPECT_EQ(totals.bus_offs, 1U);
  EXPECT_EQ(totals.restarts, 1U);
  EXPECT_EQ(totals.controller_overflows, 1U);
  EXPECT_EQ(totals.disturbances, 0U);
}

TEST(ErrorTotals, TellDestroyedFramesFromThoseThatNobodyAcknowledged) {
  ErrorTotals totals;
  totals.Take(Error(CAN_ERR_PROT | CAN_ERR_BUSERROR, {0, 0, CAN_ERR_PROT_STUFF, CAN_ERR_PROT_LOC_DATA}));
  totals.Take(Error(CAN_ERR_BUSERROR));
  totals.Take(Error(CAN_ERR_ACK | CAN_ERR_BUSERROR));
  totals.Take(
      Error(CAN_ERR_PROT | CAN_ERR_BUSERROR, {0, 0, CAN_ERR_PROT_TX, CAN_ERR_PROT_LOC_ACK}));  // SJA1000
  EXPECT_EQ(totals.disturbances, 2U);
  EXPECT_EQ(totals.missing_acknowledgements, 2U);
}

TEST(ErrorTotals, SayTheNewestInTheWordsOfCandump) {
  ErrorTotals totals;
  EXPECT_EQ(totals.DescribeLast(), "");
  totals.Take(Error(CAN_ERR_PROT | CAN_ERR_BUSERROR,
                    {0, 0, CAN_ERR_PROT_STUFF | CAN_ERR_PROT_TX, CAN_ERR_PROT_LOC_CRC_SEQ}));
  EXPECT_EQ(totals.DescribeLast(), "protocol-violation{bit-stuffing, on-transmission}{crc}, bus-error");
  totals.Take(Error(CAN_ERR_LOSTARB | CAN_ERR_CRTL, {7, CAN_ERR_CRTL_TX_PASSIVE | CAN_ERR_CRTL_RX_WARNING}));
  EXPECT_EQ(totals.DescribeLast(),
            "lost-arbitration{at bit 7}, controller-problem{rx-error-warning, tx-error-passive}");
  totals.Take(Error(CAN_ERR_PROT, {0, 0, 0, 0x77}));
  EXPECT_EQ(totals.DescribeLast(), "protocol-violation") << "a location that nobody defined";
}

}  // namespace
}  // namespace servohil::can

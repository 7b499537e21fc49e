#include "can/network.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <ctime>
#include <thread>

#include "base/error.hpp"
#include "can/slcan/terminal.hpp"

namespace servohil::can {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPatienceMs = 20'000;

std::string PathOf(const Network& network, std::size_t bus) {
  return network.Buses()[bus]->Name().substr(6);
}

/// A client with an open channel on this bus of the network.
Client Connect(Network& network, std::size_t bus) {
  Client client(PathOf(network, bus));
  client.Write("O\r");
  const auto deadline = Clock::now() + kPatience;
  while (network.Buses()[bus]->State() != "client connected, channel open" && Clock::now() < deadline) {
    EXPECT_FALSE(network.Receive(1));
  }
  EXPECT_EQ(client.ReadUntil("\r"), "\r");
  return client;
}

double ThreadCpuSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(Network, SendsToAllAndReceivesFromAny) {
  Network network({"slcan:pty", "slcan:pty"}, BusOptions{});
  const Client one = Connect(network, 0);
  const Client two = Connect(network, 1);
  EXPECT_EQ(network.Send(Numbered(1)), SendResult::kSent);
  EXPECT_EQ(one.ReadUntil("\r"), two.ReadUntil("\r"));
  for (const Client* client : {&one, &two}) {
    client->Write("t1230\r");
    const auto frame = network.Receive(kPatienceMs);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->id, 0x123U);
  }
  EXPECT_EQ(network.Statistics().received, 2U);
}

TEST(Network, ClientsOfVirtualSegmentsSeeOneAnother) {
  Network network({"slcan:pty", "slcan:pty", "slcan:pty"}, BusOptions{});
  const Client one = Connect(network, 0);
  const Client two = Connect(network, 1);
  const Client three = Connect(network, 2);
  two.Write("T1ABCDEF01FF\r");
  ASSERT_TRUE(network.Receive(kPatienceMs));
  EXPECT_EQ(one.ReadUntil("\r"), "T1ABCDEF01FF\r");
  EXPECT_EQ(three.ReadUntil("\r"), "T1ABCDEF01FF\r");
  EXPECT_EQ(two.ReadUntil("\r"), "Z\r");  // and no echo of its own
  one.Write("t0010\r");
  ASSERT_TRUE(network.Receive(kPatienceMs));
  EXPECT_EQ(two.ReadUntil("\r"), "t0010\r");
}

TEST(Network, TheWorstResultCounts) {
  Network network({"slcan:pty", "slcan:pty"}, BusOptions{});
  const Client one = Connect(network, 0);
  EXPECT_EQ(network.Send(Numbered(1)), SendResult::kDisconnected);
  EXPECT_EQ(one.ReadUntil("\r").front(), 't');
  EXPECT_EQ(network.Statistics().sent, 1U);
  EXPECT_EQ(network.Statistics().dropped_disconnected, 1U);
}

TEST(Network, FloodOnOneBusDoesNotStarveAnother) {
  constexpr int kFrames = 100;
  Network network({"slcan:pty", "slcan:pty"}, BusOptions{});
  const Client one = Connect(network, 0);
  const Client two = Connect(network, 1);
  std::string flood;
  for (int i = 0; i < kFrames; ++i) flood += "t0010\r";
  one.Write(flood);
  two.Write(flood);
  for (const int path : {0, 1}) {  // both have come to the terminals
    const auto deadline = Clock::now() + kPatience;
    pollfd entry{network.Buses()[static_cast<std::size_t>(path)]->PollFd(), POLLIN, 0};
    while (::poll(&entry, 1, 1) != 1 && Clock::now() < deadline) continue;
  }
  for (int i = 0; i < kFrames; ++i) ASSERT_TRUE(network.Receive(kPatienceMs));
  EXPECT_EQ(network.Buses()[0]->Statistics().received, kFrames / 2U);
  EXPECT_EQ(network.Buses()[1]->Statistics().received, kFrames / 2U);
}

TEST(Network, KeepsItsTimeout) {
  Network network({"slcan:pty"}, BusOptions{});
  const auto begin = Clock::now();
  EXPECT_FALSE(network.Receive(30));
  EXPECT_GE(Clock::now() - begin, std::chrono::milliseconds(30));
  EXPECT_FALSE(network.Receive(0));
}

TEST(Network, StaysWoken) {
  Network network({"slcan:pty"}, BusOptions{});
  std::thread waker([&] { network.Wake(); });
  EXPECT_FALSE(network.Receive(-1));
  waker.join();
  EXPECT_FALSE(network.Receive(-1));
}

Network* signalled_network = nullptr;

TEST(Network, WakesFromASignalHandler) {
  Network network({"slcan:pty"}, BusOptions{});
  signalled_network = &network;
  std::signal(SIGUSR1, [](int) { signalled_network->Wake(); });
  ASSERT_EQ(std::raise(SIGUSR1), 0);
  EXPECT_FALSE(network.Receive(-1));
  std::signal(SIGUSR1, SIG_DFL);
}

TEST(Network, AClientThatComesLaterIsFoundWithinAFewMilliseconds) {
  Network network({"slcan:pty"}, BusOptions{});
  EXPECT_FALSE(network.Receive(0));
  Client client(PathOf(network, 0));
  client.Write("O\rt1230\r");
  EXPECT_TRUE(network.Receive(kPatienceMs));
}

TEST(Network, ALostClientDoesNotMakeItSpin) {
  Network network({"slcan:pty", "slcan:pty"}, BusOptions{});
  { const Client client = Connect(network, 0); }
  EXPECT_FALSE(network.Receive(10));
  const double before = ThreadCpuSeconds();
  EXPECT_FALSE(network.Receive(500));
  // Fifty looks in half a second, each some microseconds; a spinning loop would take all of it.
  EXPECT_LT(ThreadCpuSeconds() - before, 0.15);
}

TEST(Network, AnAdapterPulledOutDoesNotMakeItSpin) {
  auto device = std::make_unique<Network>(std::vector<std::string>{"slcan:pty"}, BusOptions{});
  Network network({"slcan:" + PathOf(*device, 0)}, BusOptions{});
  device.reset();
  EXPECT_FALSE(network.Receive(10));
  const double before = ThreadCpuSeconds();
  EXPECT_FALSE(network.Receive(500));
  EXPECT_LT(ThreadCpuSeconds() - before, 0.15);
  EXPECT_EQ(network.Send(Numbered(1)), SendResult::kDisconnected);
}

BusOptions Modelled(std::uint32_t bit_rate_bit_s, std::size_t queue_length = 16) {
  BusOptions options;
  options.model = BusModelSettings{bit_rate_bit_s, queue_length};
  return options;
}
constexpr std::uint32_t kStandsStill = 1;  // bit/s: a frame of 8 bytes takes 135 s

TEST(Network, WithABusModelTheLowestIdentifierGoesFirst) {
  Network network({"slcan:pty"}, Modelled(kStandsStill));
  const Client client = Connect(network, 0);
  for (const std::uint32_t id : {0x7FFU, 0x203U, 0x201U, 0x202U})
    EXPECT_EQ(network.Send(Numbered(id, id)), SendResult::kSent);
  EXPECT_FALSE(network.Receive(5));
  EXPECT_EQ(network.Statistics().sent, 0U) << "all wait";
  network.Flush();
  std::string ids;
  for (int i = 0; i < 4; ++i) ids += client.ReadUntil("\r").substr(1, 3) + ' ';
  EXPECT_EQ(ids, "7FF 201 202 203 ") << "the first one had the bus for itself";
  EXPECT_EQ(network.Modelled()->frames, 4U);
}

TEST(Network, WithABusModelAFullQueueDrops) {
  Network network({"slcan:pty"}, Modelled(kStandsStill, 2));
  const Client client = Connect(network, 0);
  int dropped = 0;
  for (std::uint32_t i = 0; i < 50; ++i)
    dropped += network.Send(Numbered(i)) == SendResult::kQueueFull ? 1 : 0;
  EXPECT_EQ(dropped, 50 - 1 - 2) << "one has the bus, two wait";
  EXPECT_EQ(network.Modelled()->dropped, 47U);
  EXPECT_TRUE(network.Modelled()->Failed());
}

/// In their turn, and only then passed on to the other segments.
TEST(Network, WithABusModelWhatArrivesIsReceivedWhenItHasPassed) {
  Network network({"slcan:pty", "slcan:pty"}, Modelled(100'000));
  const Client one = Connect(network, 0);
  const Client two = Connect(network, 1);
  one.Write("t7770\rt1230\rt0010\r");
  std::string received;
  for (int i = 0; i < 3; ++i) {
    const auto frame = network.Receive(kPatienceMs);
    ASSERT_TRUE(frame);
    received += frame->id == 0x777 ? "t7770\r" : frame->id == 0x001 ? "t0010\r" : "t1230\r";
  }
  std::string forwarded;
  for (int i = 0; i < 3; ++i) forwarded += two.ReadUntil("\r");
  EXPECT_EQ(forwarded, received);
  EXPECT_EQ(network.Modelled()->frames, 3U);
}

TEST(Network, AtTheEndWhatWaitsInTheModelGoesOut) {
  Network network({"slcan:pty"}, Modelled(kStandsStill));
  const Client client = Connect(network, 0);
  network.Send(Numbered(1, 0x203));
  network.Send(Numbered(2, 0x200));
  network.Flush();
  EXPECT_EQ(network.Statistics().sent, 2U);
}

TEST(Network, WhatCannotBeOpenedIsAnError) {
  EXPECT_THROW(Network({"slcan:pty", "nonsense"}, BusOptions{}), base::UsageError);
}

TEST(Network, OneThreadReceivesWhileAnotherSends) {
  constexpr std::uint32_t kFrames = 2'000;
  Network network({"slcan:pty", "slcan:pty"}, BusOptions{});
  const Client one = Connect(network, 0);
  const Client two = Connect(network, 1);
  std::thread receiver([&] {
    while (network.Statistics().received < kFrames) network.Receive(10);
  });
  std::thread sender([&] {
    for (std::uint32_t i = 0; i < kFrames; ++i) network.Send(Numbered(i));
  });
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    one.Write("t7770\r");
    if (i % 100 == 99) {
      while (network.Statistics().received < i - 50) ::poll(nullptr, 0, 1);
    }
    one.Read();
    two.Read();
  }
  receiver.join();
  sender.join();
  EXPECT_EQ(network.Statistics().received, kFrames);
  EXPECT_EQ(network.Statistics().malformed, 0U);
}

}  // namespace
}  // namespace servohil::can

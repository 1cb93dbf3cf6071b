// SPDX-License-Identifier: Apache-2.0
// These tests show what engines are asked to do.
#include "view/view_board.h"

#include <gtest/gtest.h>

#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/error.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;
using test::message_of;

ViewLook small_look() { return {.flags = {{"--size", "8x8"}}}; }

/// A board whose engine has taken the first look.
struct BoardWithEngine {
  ViewBoard board{small_look()};
  std::shared_ptr<EngineOrders> orders = std::make_shared<EngineOrders>();

  BoardWithEngine() {
    board.set_engine(orders, false);
    (void)board.next_task(*orders);
  }
};

TEST(ViewBoard, an_engine_traces_the_path_that_a_page_waits_for) {
  BoardWithEngine at;
  auto path = std::async(std::launch::async, [&] { return at.board.path({1, 2, 3}, 60); });
  std::shared_ptr<ViewBoard::PathRequest> request;
  while (!request) request = at.board.next_task(*at.orders)->request;
  at.board.answer(*request, "[7]", "");
  EXPECT_EQ(path.get(), Json({7}));
}

TEST(ViewBoard, a_path_that_nobody_waits_for_is_not_traced) {
  BoardWithEngine at;
  for (int page = 0; page < 6; ++page)  // more than may wait at once
    EXPECT_TRUE(contains(message_of([&] { (void)at.board.path({1, 2, 3}, 0.01); }), "not traced in time"));
  EXPECT_EQ(at.board.next_task(*at.orders)->request, nullptr);
}

TEST(ViewBoard, a_path_of_the_scene_before_is_not_traced_in_another) {
  BoardWithEngine at;
  auto path = std::async(std::launch::async, [&] { return at.board.path({1, 2, 3}, 60); });
  while (!at.orders->stop) std::this_thread::yield();
  const auto other = std::make_shared<EngineOrders>();
  at.board.set_engine(other, true);
  EXPECT_THROW((void)path.get(), InputError);
  EXPECT_TRUE(at.board.next_task(*other)->look.has_value());
  EXPECT_EQ(at.board.next_task(*other)->request, nullptr);
}

}  // namespace
}  // namespace eikon

// SPDX-License-Identifier: Apache-2.0
#include "device/fault.h"

#include <CL/cl.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <thread>
#include <utility>

#include "core/clock.h"
#include "core/error.h"
#include "io/text.h"

namespace eikon {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw UsageError(
      fmt::format("EIKON_FAULT={}: {}; takes "
                  "device:POSITION[:after=N][:above=N][:times=N][:error|oom|lost|hang|stall|slow=F|wrong|gpu]",
                  text, why));
}

template <class Number>
Number number(const std::string& text, const std::string& digits) {
  const auto value = number_in<Number>(digits);
  if (!value) refuse(text, fmt::format("'{}' is no number that it can take", digits));
  return *value;
}

void apply(FaultPlan& plan, const std::string& field, const std::string& text) {
  static const std::map<std::string, FaultPlan::Kind> kinds = {
      {"error", FaultPlan::Kind::error}, {"oom", FaultPlan::Kind::oom},     {"lost", FaultPlan::Kind::lost},
      {"hang", FaultPlan::Kind::hang},   {"stall", FaultPlan::Kind::stall}, {"slow", FaultPlan::Kind::slow},
      {"wrong", FaultPlan::Kind::wrong}, {"gpu", FaultPlan::Kind::gpu}};
  const std::size_t equals = field.find('=');
  const std::string name = field.substr(0, equals);
  const auto value = [&] { return equals == std::string::npos ? std::string() : field.substr(equals + 1); };
  const auto kind = kinds.find(name);
  if (name == "after")
    plan.after = number<std::uint64_t>(text, value());
  else if (name == "above")
    plan.above = number<std::uint64_t>(text, value());
  else if (name == "times")
    plan.times = number<std::uint64_t>(text, value());
  else if (kind == kinds.end() || (equals != std::string::npos && name != "slow"))
    refuse(text, fmt::format("'{}' is nothing that can be asked for", field));
  else
    plan.kind = kind->second;
  if (name != "slow") return;
  plan.factor = number<double>(text, value());
  if (!(plan.factor >= 1) || plan.factor > 1e6) refuse(text, "slow takes a factor from 1 to 1000000");
}

[[noreturn]] void hang() {
  std::mutex mutex;
  std::condition_variable never;
  std::unique_lock lock(mutex);
  for (;;) never.wait(lock);
}

}  // namespace

std::vector<FaultPlan> parse_faults(const std::string& text) {
  std::vector<FaultPlan> plans;
  for (const std::string& entry : split(text, ';')) {
    const std::vector<std::string> fields = split(entry, ':');
    if (fields[0] != "device" || fields.size() < 2) refuse(text, "it does not begin with device:POSITION");
    FaultPlan& plan = plans.emplace_back();
    plan.device = number<std::uint32_t>(text, fields[1]);
    for (std::size_t i = 2; i < fields.size(); ++i) apply(plan, fields[i], text);
  }
  return plans;
}

Fault::Fault(std::vector<FaultPlan> plans) : plans_(std::move(plans)) {}

bool Fault::acts_as_gpu() const {
  return std::ranges::any_of(plans_, [](const FaultPlan& plan) { return plan.kind == FaultPlan::Kind::gpu; });
}

bool Fault::is_harmless() const {
  return std::ranges::all_of(plans_, [](const FaultPlan& plan) { return plan.kind == FaultPlan::Kind::gpu; });
}

void Fault::begin_unit(std::uint64_t paths) {
  const std::lock_guard lock(mutex_);
  ++units_;
  paths_ = paths;
  begins_ = true;
}

int Fault::fail(FaultPlan& plan) {
  if (plan.times != std::numeric_limits<std::uint64_t>::max()) --plan.times;
  if (plan.kind == FaultPlan::Kind::lost) lost_ = true;
  if (plan.kind == FaultPlan::Kind::hang || plan.kind == FaultPlan::Kind::stall) hung_ = true;
  return plan.kind == FaultPlan::Kind::lost  ? CL_DEVICE_NOT_AVAILABLE
         : plan.kind == FaultPlan::Kind::oom ? CL_MEM_OBJECT_ALLOCATION_FAILURE
                                             : CL_OUT_OF_RESOURCES;
}

int Fault::at(Call call) {
  int code = CL_SUCCESS;
  {
    const std::lock_guard lock(mutex_);
    if (lost_) return CL_DEVICE_NOT_AVAILABLE;
    const bool first_launch = call == Call::launch && std::exchange(begins_, false);
    for (FaultPlan& plan : plans_) {
      const bool early = !plan.after && ((plan.kind == FaultPlan::Kind::lost && call == Call::open) ||
                                         (plan.kind == FaultPlan::Kind::oom && call == Call::allocate));
      const bool stalls = plan.kind == FaultPlan::Kind::stall;
      const bool between = stalls && call == Call::finish && units_ >= plan.after.value_or(0);
      const bool in_unit = !stalls && first_launch && units_ > plan.after.value_or(0) && paths_ > plan.above;
      const bool fails = plan.kind != FaultPlan::Kind::slow && plan.kind != FaultPlan::Kind::wrong &&
                         plan.kind != FaultPlan::Kind::gpu;
      if (fails && code == CL_SUCCESS && plan.times > 0 && (early || in_unit || between)) code = fail(plan);
    }
  }
  if (hung_) hang();
  return code;
}

void Fault::slow_down(double busy_s) {
  double factor = 1;
  for (const FaultPlan& plan : plans_)
    if (plan.kind == FaultPlan::Kind::slow) factor *= plan.factor;
  if (factor <= 1 || busy_s <= 0) return;
  double rest_s = 0;
  {
    const std::lock_guard lock(mutex_);
    const double now_s = host_seconds();
    slow_until_s_ = std::max(slow_until_s_, now_s - busy_s) + factor * busy_s;
    rest_s = slow_until_s_ - now_s;
  }
  if (rest_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(rest_s));
}

void Fault::spoil(void* data, std::size_t bytes) const {
  for (const FaultPlan& plan : plans_)
    if (plan.kind == FaultPlan::Kind::wrong && bytes > 0) *static_cast<unsigned char*>(data) ^= 1U;
}

}  // namespace eikon

#include "event_feed.hpp"

#include <chrono>
#include <iterator>
#include <utility>

namespace torsio {
namespace {

// How long a callback that is late may still be told what came before the knob was closed.
constexpr std::chrono::seconds kLastWords{1};

}  // namespace

void EventFeed::add(const Event& event) {
  {
    const std::lock_guard lock(mutex_);
    kept_.push_back(event);
    if (kept_.size() > kMost) {
      kept_.pop_front();
      ++lost_;
    }
  }
  const std::lock_guard lock(telling_->mutex);
  if (telling_->callback == nullptr) return;
  telling_->events.push_back(event);
  if (telling_->events.size() > kMost) telling_->events.pop_front();
  telling_->news.notify_all();
}

std::vector<Event> EventFeed::take() {
  const std::lock_guard lock(mutex_);
  std::vector<Event> taken(std::make_move_iterator(kept_.begin()),
                           std::make_move_iterator(kept_.end()));
  kept_.clear();
  return taken;
}

bool EventFeed::empty() const {
  const std::lock_guard lock(mutex_);
  return kept_.empty();
}

std::uint64_t EventFeed::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

void EventFeed::set_callback(Callback callback) {
  const bool wanted = static_cast<bool>(callback);
  auto changed = wanted ? std::make_shared<const Callback>(std::move(callback)) : nullptr;
  std::exception_ptr failure;
  {
    const std::lock_guard lock(telling_->mutex);
    if (telling_->closed) return;
    telling_->events.clear();
    telling_->callback.swap(changed);
    has_callback_ = wanted;
    failure = std::exchange(telling_->failure, nullptr);
  }
  changed.reset();  // the old one's end may be anything, so it comes under no lock
  if (failure) std::rethrow_exception(failure);
  const std::lock_guard lock(thread_mutex_);
  if (wanted && own_thread_ && !thread_.joinable()) {
    thread_ = std::thread([telling = telling_] { telling->run(); });
  }
}

/// @returns false if there was nothing to tell. A child that the callback forked has no other
/// threads: there it returns false with the lock open
bool EventFeed::Telling::tell_one(std::unique_lock<std::mutex>& lock) {
  if (closed || events.empty() || callback == nullptr) return false;
  const Event event = std::move(events.front());
  events.pop_front();
  std::shared_ptr<const Callback> call = callback;
  teller = std::this_thread::get_id();
  lock.unlock();
  std::exception_ptr thrown;
  try {
    (*call)(event);
  } catch (...) {
    thrown = std::current_exception();
  }
  if (!process.is_this()) return false;
  lock.lock();
  if (thrown && callback == call) {
    failure = thrown;
    callback = nullptr;
    events.clear();
  }
  lock.unlock();
  call.reset();  // its end may be anything too
  lock.lock();
  teller = {};
  news.notify_all();
  return true;
}

void EventFeed::Telling::run() {
  std::unique_lock lock(mutex);
  while (!closed) {
    if (tell_one(lock)) continue;
    if (!lock.owns_lock()) return;  // a forked child ends with its only thread
    news.wait(lock, [&] { return closed || !events.empty(); });
  }
}

void EventFeed::tell() {
  if (own_thread_ || !has_callback_) return;
  std::unique_lock lock(telling_->mutex);
  if (telling_->teller != std::thread::id()) return;
  while (telling_->tell_one(lock)) {
  }
}

bool EventFeed::tells_here() const {
  const std::lock_guard lock(telling_->mutex);
  return telling_->teller == std::this_thread::get_id();
}

void EventFeed::close() noexcept {
  if (own_thread_) {
    // That the torque went is the last there is to tell, and mostly comes right before this.
    std::unique_lock lock(telling_->mutex);
    telling_->news.wait_for(lock, kLastWords, [&] {
      return telling_->teller == std::this_thread::get_id() || telling_->callback == nullptr ||
             (telling_->events.empty() && telling_->teller == std::thread::id());
    });
  }
  // A callback often has the knob that has it: kept any longer, neither would ever go.
  std::shared_ptr<const Callback> dropped;
  {
    const std::lock_guard lock(telling_->mutex);
    telling_->closed = true;
    telling_->callback.swap(dropped);
    telling_->events.clear();
  }
  telling_->news.notify_all();
  dropped.reset();
  {
    std::unique_lock lock(telling_->mutex);
    if (telling_->teller == std::this_thread::get_id()) return;
    telling_->news.wait(lock, [&] { return telling_->teller == std::thread::id(); });
  }
  const std::lock_guard lock(thread_mutex_);
  if (thread_.joinable()) thread_.join();
}

EventFeed::~EventFeed() {
  close();
  if (thread_.joinable()) thread_.detach();  // the callback itself was the last to have the knob
}

}  // namespace torsio

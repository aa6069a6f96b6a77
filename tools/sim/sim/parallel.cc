#include "tools/sim/sim/parallel.h"

#include "common/core/check.h"

namespace gw::sim {

WorkerPool::WorkerPool(int threads) {
  GW_CHECK(threads >= 1);
  for (int i = 1; i < threads; ++i) workers_.emplace_back([this, i] { Loop(i); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void WorkerPool::Run(int count, const std::function<void(int, int)>& work) {
  std::unique_lock lock(mutex_);
  work_ = &work;
  next_ = 0;
  count_ = count;
  wake_.notify_all();
  Drain(0, &lock);
  done_.wait(lock, [this] { return busy_ == 0; });
  work_ = nullptr;
}

void WorkerPool::Loop(int thread) {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stop_ || (work_ != nullptr && next_ < count_); });
    if (stop_) return;
    Drain(thread, &lock);
    done_.notify_all();
  }
}

void WorkerPool::Drain(int thread, std::unique_lock<std::mutex>* lock) {
  while (next_ < count_) {
    const int piece = next_++;
    ++busy_;
    lock->unlock();
    (*work_)(piece, thread);
    lock->lock();
    --busy_;
  }
}

}  // namespace gw::sim

// Runs independent pieces of work on a fixed number of threads. The result must not depend on which
// thread does which piece: pieces write to places of their own.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace gw::sim {

class WorkerPool {
 public:
  // threads: >= 1, the calling thread is one of them.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int num_threads() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls work(piece, thread) for every piece in [0, count); returns when all are done.
  void Run(int count, const std::function<void(int piece, int thread)>& work);

 private:
  void Loop(int thread);
  void Drain(int thread, std::unique_lock<std::mutex>* lock);

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(int, int)>* work_ = nullptr;
  int next_ = 0, count_ = 0, busy_ = 0;
  bool stop_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace gw::sim

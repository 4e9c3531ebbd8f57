// Workers that are MPI processes; rank 0 leads. A library of its own, which is loaded under mpirun
// alone.
//
// By its names with a P: the solver of Ipopt (MUMPS for one process) brings functions of its own
// that are called MPI_Comm_rank and MPI_Finalize, and the program has found those first.
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "optim/solvers/sharing.hpp"

namespace flexopt {
namespace {

enum Tag { question = 1, answer_to, end_of_stage, text_for_all, failed, over };

struct Message {
  int rank = 0, tag = 0;
  std::string text;
};

/// Pauses between looks for a message, ever longer ones: MPI's own waiting would keep a processor
/// busy.
class Patience {
 public:
  using Pause = std::chrono::microseconds;
  Pause next() {
    if (pause_ < longest) pause_ += pause_ / 4;
    return pause_;
  }
  void renew() { pause_ = shortest; }

 private:
  static constexpr Pause shortest{20}, longest{250};
  Pause pause_ = shortest;
};

/// MPI's calls, one at a time.
class Post {
 public:
  void send(int rank, Tag tag, const std::string& text) {
    const std::lock_guard lock(mutex_);
    PMPI_Send(text.data(), static_cast<int>(text.size()), MPI_BYTE, rank, tag, MPI_COMM_WORLD);
  }
  /// The next message, if there is one.
  bool receive(Message& message) {
    const std::lock_guard lock(mutex_);
    int there = 0;
    MPI_Status status;
    PMPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status);
    if (!there) return false;
    int size = 0;
    PMPI_Get_count(&status, MPI_BYTE, &size);
    message = {status.MPI_SOURCE, status.MPI_TAG, std::string(static_cast<std::size_t>(size), 0)};
    PMPI_Recv(message.text.data(), size, MPI_BYTE, message.rank, message.tag, MPI_COMM_WORLD,
              MPI_STATUS_IGNORE);
    return true;
  }

 private:
  std::mutex mutex_;
};

/// Rank 0. Questions wait in a row; a thread of its own hands them to ranks that are free and takes
/// what they answer.
class Leader : public Workers {
 public:
  explicit Leader(int members) : members_(members) {
    for (int rank = members - 1; rank > 0; --rank) free_.push_back(rank);
    asked_.resize(static_cast<std::size_t>(members), nullptr);
    postman_ = std::thread([this] { carry(); });
  }
  ~Leader() override {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    more_.notify_all();
    postman_.join();
    for (int rank = 1; rank < members_; ++rank) post_.send(rank, over, "");
    PMPI_Finalize();
  }

  bool leads() const override { return true; }
  int members() const override { return members_; }

  std::string ask(const std::string& text, const Answerer& here) override {
    Question mine(text);
    std::unique_lock lock(mutex_);
    row_.push_back(&mine);
    more_.notify_one();
    for (;;) {
      if (!broken_.empty()) {
        std::erase(row_, &mine);
        std::replace(asked_.begin(), asked_.end(), &mine, static_cast<Question*>(nullptr));
        throw WorkersLost(broken_);
      }
      if (mine.answered) return std::move(mine.answer);
      if (!mine.given && !working_) {
        std::erase(row_, &mine);
        return work(mine.text, here, lock);
      }
      mine.news.wait(lock);
    }
  }

  void end_stage() override { to_all(end_of_stage, ""); }
  void tell(const std::string& text) override { to_all(text_for_all, text); }
  void answer(const Answerer&) override {}
  std::string hear() override { return {}; }
  void fail(const std::string&) override {}

 private:
  struct Question {
    explicit Question(const std::string& asked) : text(asked) {}
    const std::string& text;
    std::string answer;
    bool given = false, answered = false;
    std::condition_variable news;
  };

  /// Does the work in this process, one unit at a time.
  std::string work(const std::string& text, const Answerer& here,
                   std::unique_lock<std::mutex>& lock) {
    working_ = true;
    lock.unlock();
    struct Done {
      Leader& of;
      std::unique_lock<std::mutex>& lock;
      ~Done() {
        lock.lock();
        of.working_ = false;
        if (!of.row_.empty()) of.row_.front()->news.notify_one();
      }
    } const done{*this, lock};
    return here(text);
  }

  void to_all(Tag tag, const std::string& text) {
    for (int rank = 1; rank < members_; ++rank) post_.send(rank, tag, text);
  }

  void carry() {
    Patience patience;
    std::unique_lock lock(mutex_);
    while (!ended_) {
      while (!row_.empty() && !free_.empty()) {
        Question* const next = row_.front();
        const int rank = free_.back();
        row_.pop_front();
        free_.pop_back();
        next->given = true;
        asked_[rank] = next;
        patience.renew();
        post_.send(rank, question, next->text);
      }
      Message message;
      if (post_.receive(message)) {
        patience.renew();
        take(std::move(message));
        continue;
      }
      more_.wait_for(lock, patience.next());
    }
  }

  void take(Message message) {
    Question*& of = asked_[message.rank];
    if (message.tag == failed || !of) {
      broken_ = "rank " + std::to_string(message.rank) + ": " + message.text;
      for (Question* waiting : row_) waiting->news.notify_one();
      for (Question* waiting : asked_)
        if (waiting) waiting->news.notify_one();
      return;
    }
    of->answer = std::move(message.text);
    of->answered = true;
    of->news.notify_one();
    of = nullptr;
    free_.push_back(message.rank);
  }

  int members_;
  Post post_;
  std::mutex mutex_;
  std::condition_variable more_;
  std::deque<Question*> row_;
  std::vector<int> free_;
  std::vector<Question*> asked_;  ///< by rank
  bool working_ = false, ended_ = false;
  std::string broken_;  ///< why a rank cannot go on
  std::thread postman_;
};

/// Workers member on the other ranks.
class Follower : public Workers {
 public:
  explicit Follower(int members) : members_(members) {}
  ~Follower() override {
    // until rank 0 has ended: it may still be sending
    while (!over_) next();
    PMPI_Finalize();
  }

  bool leads() const override { return false; }
  int members() const override { return members_; }
  std::string ask(const std::string&, const Answerer&) override { return {}; }
  void end_stage() override {}
  void tell(const std::string&) override {}

  void answer(const Answerer& here) override {
    for (;;) {
      const Message message = next();
      if (message.tag == end_of_stage) return;
      dismissed(message);
      post_.send(0, answer_to, here(message.text));
    }
  }
  std::string hear() override {
    Message message = next();
    dismissed(message);
    return std::move(message.text);
  }
  void fail(const std::string& why) override { post_.send(0, failed, why); }

 private:
  static void dismissed(const Message& message) {
    if (message.tag == over) throw WorkersDismissed();
  }
  Message next() {
    Message message;
    Patience patience;
    while (!post_.receive(message)) std::this_thread::sleep_for(patience.next());
    over_ = message.tag == over;
    return message;
  }

  int members_;
  bool over_ = false;
  Post post_;
};

}  // namespace
}  // namespace flexopt

/// Called once by each process that mpirun has started.
extern "C" flexopt::Workers* flexopt_join_workers() {
  int given = 0, rank = 0, members = 1;
  PMPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &given);
  PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  PMPI_Comm_size(MPI_COMM_WORLD, &members);
  if (rank == 0) return new flexopt::Leader(members);
  return new flexopt::Follower(members);
}

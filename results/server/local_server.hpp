#pragma once
// Sockets of the server: one thread reads all requests and sends all answers, as fast as each
// client likes it; a thread of a small pool is given a request when it is whole. Clients that send
// or read slowly, or not at all, keep nobody busy.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace flexopt {

/// A socket that listens on the loopback interface alone.
struct Listener {
  int socket = -1;
  int port = 0;
};

/// Listens on this port, or on a free one for 0. Throws SpecError (pointer --port).
Listener listen_on_loopback(int port);

class Connections {
 public:
  /// The whole answer to a whole request (RequestText::text); in threads of the pool.
  using Answer = std::function<std::string(const std::string& request)>;
  /// What is said to one that is refused.
  using Refuse = std::function<std::string(int status, const std::string& reason)>;

  /// Closes the listener's socket in the end. Throws std::system_error.
  Connections(const Listener& listener, Answer answer, Refuse refuse);
  ~Connections();
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  /// Serves until `stop_signal`, a descriptor, can be read. Requests that are being answered then
  /// still are, for `patience` at most. True if all of them were.
  bool run(int stop_signal, std::chrono::milliseconds patience);

 private:
  using Clock = std::chrono::steady_clock;
  enum class Phase { asking, answered, refused, leaving };
  struct Client {
    int socket = -1;
    Clock::time_point deadline;
    Phase phase = Phase::asking;
    std::string bytes;     ///< what came, then what goes
    std::size_t done = 0;  ///< bytes sent, or in the end thrown away
  };
  struct Whole {
    int socket = -1;
    std::string text;  ///< request, then answer
  };

  void accept_all();
  /// Serve a client; return false when the client is finished.
  bool attend(Client& client, short ready);
  bool read_from(Client& client);
  bool send_to(Client& client);
  void refuse(Client& client, int status, const std::string& reason);
  bool hand_over(Client& client, std::string text);
  void take_answers();
  void work();

  int listener_;
  Answer answer_;
  Refuse refuse_;
  std::vector<Client> clients_;  ///< oldest first

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Whole> whole_, answers_;
  int answer_came_ = -1;  ///< descriptor
  int busy_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

// A server for the browser of the same user on the same machine: the loopback interface alone, a
// token in its address, a fixed number of threads.

struct ServerAnswer {
  int status = 200;
  std::string body;
  std::string type = "application/json";
};

class LocalServer {
 public:
  /// Listens on this port, or on a free one for 0; from here on Ctrl-C waits for `run`. Throws
  /// SpecError (pointer --port).
  explicit LocalServer(int port);
  ~LocalServer();
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;

  /// Serves the page at "/". `nonce`: value that its scripts must carry.
  void page(std::function<std::string(const std::string& nonce)> make);
  /// Sets the answer to a POST of a body to this path; the path is letters after "/". May run in
  /// several threads at once. A SpecError that it throws is answered by 400 and its text.
  void post(const std::string& path, std::function<ServerAnswer(const std::string& body)> answer);

  /// Address of the page: http://127.0.0.1:PORT/?token=…
  std::string address() const;
  /// Serves until SIGINT or SIGTERM. An answer that is then under way for some seconds more is
  /// given up, and with it the process, with exit code 0: it would be nothing but a text.
  void run();

 private:
  class Library;

  Listener listener_;
  std::string token_;
  int signals_ = -1;
  std::unique_ptr<Library> library_;
};

}  // namespace flexopt

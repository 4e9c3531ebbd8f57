#pragma once
// A server for the browser of the same user on the same machine: the loopback interface alone, a
// token in its address, a fixed number of threads.
#include <functional>
#include <memory>
#include <string>

#include "results/server/connections.hpp"

namespace flexopt {

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

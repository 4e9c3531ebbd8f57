#include <sys/eventfd.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "results/server/local_server.hpp"
#include "support/loopback.hpp"
#include "tests/results/results_tests.hpp"

using namespace std::chrono_literals;

namespace {

const std::string get = "GET / HTTP/1.1\r\nHost: here\r\n\r\n";

/// Answers with the request itself.
class Echo {
 public:
  explicit Echo(std::function<std::string(const std::string&)> answer)
      : stop_(::eventfd(0, EFD_CLOEXEC)),
        listener_(listen_on_loopback(0)),
        connections_(listener_, std::move(answer),
                     [](int status, const std::string&) { return std::to_string(status); }),
        thread_([this] { all_done_ = connections_.run(stop_, 5s); }) {}
  ~Echo() {
    stop();
    ::close(stop_);
  }
  int port() const { return listener_.port; }
  bool stop() {
    const std::uint64_t one = 1;
    (void)!::write(stop_, &one, sizeof one);
    if (thread_.joinable()) thread_.join();
    return all_done_;
  }

 private:
  int stop_;
  Listener listener_;
  Connections connections_;
  std::atomic<bool> all_done_ = false;
  std::thread thread_;
};

}  // namespace

TEST_CASE("Hundreds of silent clients keep nobody from being answered") {
  Echo echo([](const std::string& request) { return request; });
  std::vector<test::Client> silent;
  for (int i = 0; i < 400; ++i) {
    silent.emplace_back(echo.port());
    if (i % 2) silent.back().send(get.substr(0, 20));
  }
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i)
    CHECK(test::asked(echo.port(), get) == "GET / HTTP/1.1\r\nhost: here\r\n\r\n");
  CHECK(std::chrono::steady_clock::now() - begin < 2s);  // clients are given up after 5 s
  CHECK(test::asked(echo.port(), "PUT / HTTP/1.1\r\n\r\n") == "405");
  CHECK(echo.stop());
}

TEST_CASE("Clients that do not read their answers keep no thread") {
  const std::string large(8 << 20, 'x');
  Echo echo([&](const std::string&) { return large; });
  std::vector<test::Client> deaf;
  for (int i = 0; i < 12; ++i) {
    deaf.emplace_back(echo.port());
    deaf.back().send(get);
  }
  const auto begin = std::chrono::steady_clock::now();
  CHECK(test::asked(echo.port(), get).size() == large.size());
  CHECK(std::chrono::steady_clock::now() - begin < 4s);  // and these after 10 s
}

TEST_CASE("A request that comes letter by letter is answered") {
  Echo echo([](const std::string& request) { return request; });
  test::Client client(echo.port());
  for (const char letter : get) {
    client.send({&letter, 1});
    std::this_thread::sleep_for(1ms);
  }
  CHECK(client.receive() == "GET / HTTP/1.1\r\nhost: here\r\n\r\n");
}

TEST_CASE("What is being answered at the end is waited for") {
  std::atomic<bool> begun = false, ended = false;
  Echo echo([&](const std::string& request) {
    begun = true;
    std::this_thread::sleep_for(200ms);
    ended = true;
    return request;
  });
  test::Client client(echo.port());
  client.send(get);
  while (!begun) std::this_thread::sleep_for(1ms);
  CHECK(echo.stop());
  CHECK(ended);
}

TEST_CASE("A port that is taken is wrong input") {
  const Listener listener = listen_on_loopback(0);
  CHECK(listener.port > 0);
  const SpecError error = test::refusal_of([&] { (void)listen_on_loopback(listener.port); });
  CHECK(error.pointer() == "--port");
  CHECK(error.value() == std::to_string(listener.port));
  ::close(listener.socket);
}

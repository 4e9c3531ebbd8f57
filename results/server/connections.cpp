#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "core/spec/spec_error.hpp"
#include "results/server/guard.hpp"
#include "results/server/local_server.hpp"

namespace flexopt {

using namespace std::chrono_literals;

namespace {

constexpr std::size_t most_clients = 200;  // the oldest goes when one more comes
constexpr std::size_t most_waiting = 64;   // whole requests without a thread
constexpr int threads = 4;                 // two may wait for an evaluation, the others are free
constexpr auto time_to_ask = 5s;           // from the connection to a whole request
constexpr auto time_to_read = 10s;         // the whole answer
constexpr auto time_to_leave = 1s;         // after a refusal
constexpr std::size_t most_thrown_away = 1 << 20;

int milliseconds_until(std::chrono::steady_clock::time_point time) {
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(time - std::chrono::steady_clock::now());
  return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 60000));
}

}  // namespace

Listener listen_on_loopback(int port) {
  const auto refuse = [&](int error) -> SpecError {
    return {"--port", std::to_string(port),
            "expected a port that is free: " + std::generic_category().message(error)};
  };
  Listener listener{::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), port};
  if (listener.socket < 0) throw refuse(errno);
  const int on = 1;
  ::setsockopt(listener.socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* plain = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listener.socket, plain, size) != 0 || ::listen(listener.socket, 128) != 0 ||
      ::getsockname(listener.socket, plain, &size) != 0) {
    const int error = errno;
    ::close(listener.socket);
    throw refuse(error);
  }
  listener.port = ntohs(address.sin_port);
  return listener;
}

Connections::Connections(const Listener& listener, Answer answer, Refuse refuse)
    : listener_(listener.socket),
      answer_(std::move(answer)),
      refuse_(std::move(refuse)),
      answer_came_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (answer_came_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  for (int i = 0; i < threads; ++i) workers_.emplace_back([this] { work(); });
}

Connections::~Connections() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  for (std::thread& worker : workers_) worker.join();
  for (const auto& list : {whole_, answers_})
    for (const Whole& one : list) ::close(one.socket);
  for (const Client& client : clients_) ::close(client.socket);
  if (listener_ >= 0) ::close(listener_);
  ::close(answer_came_);
}

bool Connections::run(int stop_signal, std::chrono::milliseconds patience) {
  std::vector<pollfd> watched;
  while (true) {
    watched.assign({{stop_signal, POLLIN, 0}, {listener_, POLLIN, 0}, {answer_came_, POLLIN, 0}});
    const std::size_t first = watched.size();
    auto next = Clock::now() + 60s;
    for (const Client& client : clients_) {
      const bool sends = client.phase == Phase::answered || client.phase == Phase::refused;
      watched.push_back({client.socket, static_cast<short>(sends ? POLLOUT : POLLIN), 0});
      next = std::min(next, client.deadline);
    }
    if (::poll(watched.data(), watched.size(), milliseconds_until(next)) < 0 && errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "poll");
    if (watched[0].revents != 0) break;
    std::vector<Client> kept;
    for (std::size_t i = 0; i < clients_.size(); ++i)
      if (attend(clients_[i], watched[first + i].revents)) kept.push_back(std::move(clients_[i]));
    clients_ = std::move(kept);
    if (watched[2].revents != 0) take_answers();
    if (watched[1].revents != 0) accept_all();
  }
  ::close(listener_);
  listener_ = -1;
  std::unique_lock lock(mutex_);
  stopping_ = true;
  changed_.notify_all();
  return changed_.wait_for(lock, patience, [&] { return busy_ == 0; });
}

void Connections::accept_all() {
  for (std::size_t i = 0; i < most_clients; ++i) {  // then the others have their turn
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    const bool full = socket < 0 && (errno == EMFILE || errno == ENFILE);
    if (!clients_.empty() && (full || (socket >= 0 && clients_.size() >= most_clients))) {
      ::close(clients_.front().socket);
      clients_.erase(clients_.begin());
    }
    if (socket < 0) {
      if (full) std::this_thread::sleep_for(10ms);
      return;
    }
    const int on = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    clients_.push_back({socket, Clock::now() + time_to_ask});
  }
}

bool Connections::attend(Client& client, short ready) {
  bool goes_on = true;
  if (Clock::now() >= client.deadline) {
    if (client.phase == Phase::asking)
      refuse(client, 408, "the request took too long");
    else
      goes_on = false;
  } else if (ready != 0) {
    const bool reads = client.phase == Phase::asking || client.phase == Phase::leaving;
    if (reads && !read_from(client)) return false;
    goes_on = reads || send_to(client);
  }
  if (!goes_on) ::close(client.socket);
  return goes_on;
}

/// Closes the socket, or gives it away, where that is all.
bool Connections::read_from(Client& client) {
  std::array<char, 16384> buffer;
  const ssize_t got = ::recv(client.socket, buffer.data(), buffer.size(), 0);
  if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return true;
  const bool leaves = client.phase == Phase::leaving;
  if (leaves && got > 0) client.done += static_cast<std::size_t>(got);
  if (got <= 0 || (leaves && client.done > most_thrown_away)) {
    ::close(client.socket);
    return false;
  }
  if (leaves) return true;
  client.bytes.append(buffer.data(), static_cast<std::size_t>(got));
  RequestText request = read_request(client.bytes);
  if (request.state == RequestText::State::whole) return hand_over(client, std::move(request.text));
  if (request.state == RequestText::State::refused) refuse(client, request.status, request.reason);
  return true;
}

bool Connections::send_to(Client& client) {
  while (client.done < client.bytes.size()) {
    const ssize_t sent = ::send(client.socket, client.bytes.data() + client.done,
                                client.bytes.size() - client.done, MSG_NOSIGNAL);
    if (sent > 0)
      client.done += static_cast<std::size_t>(sent);
    else if (errno == EAGAIN || errno == EWOULDBLOCK)
      return true;
    else if (errno != EINTR)
      return false;
  }
  if (client.phase == Phase::answered) return false;
  // A client that still sends would not see the refusal if the socket were closed at once.
  ::shutdown(client.socket, SHUT_WR);
  client = {client.socket, Clock::now() + time_to_leave, Phase::leaving};
  return true;
}

void Connections::refuse(Client& client, int status, const std::string& reason) {
  client = {client.socket, Clock::now() + time_to_read, Phase::refused, refuse_(status, reason)};
}

bool Connections::hand_over(Client& client, std::string text) {
  {
    const std::lock_guard lock(mutex_);
    if (whole_.size() < most_waiting) {
      whole_.push_back({client.socket, std::move(text)});
      changed_.notify_all();
      return false;
    }
  }
  refuse(client, 503, "too many requests");
  return true;
}

void Connections::take_answers() {
  std::uint64_t count = 0;
  (void)!::read(answer_came_, &count, sizeof count);
  const std::lock_guard lock(mutex_);
  for (Whole& one : answers_)
    clients_.push_back(
        {one.socket, Clock::now() + time_to_read, Phase::answered, std::move(one.text)});
  answers_.clear();
}

void Connections::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stopping_ || !whole_.empty(); });
    if (stopping_) return;
    Whole request = std::move(whole_.front());
    whole_.pop_front();
    ++busy_;
    lock.unlock();
    request.text = answer_(request.text);
    lock.lock();
    --busy_;
    answers_.push_back(std::move(request));
    const std::uint64_t one = 1;
    (void)!::write(answer_came_, &one, sizeof one);
    changed_.notify_all();
  }
}

}  // namespace flexopt

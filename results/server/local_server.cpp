#include "results/server/local_server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/spec/spec_error.hpp"
#include "results/server/guard.hpp"

namespace flexopt {

namespace {

using namespace std::chrono_literals;

constexpr auto patience = 2s;  // with answers that are under way at the end

/// One whole request that is read from memory; what is written is kept for the socket.
class OneRequest : public httplib::Stream {
 public:
  explicit OneRequest(std::string_view request) : request_(request) {}

  bool is_readable() const override { return !request_.empty(); }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override {
    const std::size_t part = std::min(size, request_.size());
    std::memcpy(to, request_.data(), part);
    request_.remove_prefix(part);
    return static_cast<ssize_t>(part);
  }
  ssize_t write(const char* from, std::size_t size) override {
    answer_.append(from, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return 0; }  // none that the library may wait for

  const std::string& answer() const { return answer_; }

 private:
  std::string_view request_;
  std::string answer_;
};

/// What every answer says. Pages of others may neither read nor frame it, and nothing is kept.
const httplib::Headers& safe_headers() {
  static const httplib::Headers headers{{"Cache-Control", "no-store"},
                                        {"X-Content-Type-Options", "nosniff"},
                                        {"X-Frame-Options", "DENY"},
                                        {"Referrer-Policy", "no-referrer"},
                                        {"Cross-Origin-Resource-Policy", "same-origin"},
                                        {"Cross-Origin-Opener-Policy", "same-origin"}};
  return headers;
}

/// The page's own scripts and requests to this server, and nothing else.
std::string policy_of_page(const std::string& nonce) {
  return fmt::format(
      "default-src 'none'; script-src 'nonce-{}'; style-src 'unsafe-inline'; img-src data: blob:; "
      "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
      nonce);
}

constexpr const char* policy_of_data = "default-src 'none'; frame-ancestors 'none'";

void say(httplib::Response& response, int status, const std::string& text) {
  response.status = status;
  response.set_content(text + "\n", "text/plain; charset=utf-8");
}

std::string refusal_text(int status, const std::string& reason) {
  std::string text = fmt::format("HTTP/1.1 {} Refused\r\n", status);
  for (const auto& [name, value] : safe_headers()) text += fmt::format("{}: {}\r\n", name, value);
  text += fmt::format(
      "Content-Type: text/plain; charset=utf-8\r\nContent-Length: {}\r\nConnection: close\r\n\r\n"
      "{}\n",
      reason.size() + 1, reason);
  return text;
}

}  // namespace

/// The library parses requests, finds who answers, and writes answers; sockets are ours.
class LocalServer::Library : public httplib::Server {
 public:
  std::string answer_to(const std::string& request) {
    OneRequest stream(request);
    bool closed = false;
    process_request(stream, true, closed, nullptr);
    return stream.answer();
  }
};

LocalServer::LocalServer(int port)
    : listener_(listen_on_loopback(port)),
      token_(random_token()),
      library_(std::make_unique<Library>()) {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);  // in all threads that come after this one
  signals_ = ::signalfd(-1, &ends, SFD_CLOEXEC);
  library_->set_default_headers(safe_headers());
  library_->set_payload_max_length(largest_body);
  library_->set_pre_routing_handler([this](const httplib::Request& request,
                                           httplib::Response& response) {
    std::string token = request.get_header_value("X-Flexopt-Token");
    if (token.empty() && request.method == "GET") token = request.get_param_value("token");
    const auto refused = refusal(
        {request.get_header_value("Host"), request.get_header_value("Origin"), std::move(token)},
        listener_.port, token_);
    if (!refused) return httplib::Server::HandlerResponse::Unhandled;
    say(response, refused->status, refused->reason);
    return httplib::Server::HandlerResponse::Handled;
  });
  library_->set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, std::exception_ptr error) {
        try {
          std::rethrow_exception(std::move(error));
        } catch (const SpecError& wrong) {
          say(response, 400, wrong.what());
        } catch (const std::exception& bug) {
          say(response, 500, std::string("a bug of flexopt, please report it: ") + bug.what());
        }
      });
  library_->set_error_handler([](const httplib::Request&, httplib::Response& response) {
    if (response.body.empty()) say(response, response.status, "nothing here");
  });
}

LocalServer::~LocalServer() {
  if (signals_ >= 0) ::close(signals_);
  if (listener_.socket >= 0) ::close(listener_.socket);
}

void LocalServer::page(std::function<std::string(const std::string& nonce)> make) {
  library_->Get("/",
                [make = std::move(make)](const httplib::Request&, httplib::Response& response) {
                  const std::string nonce = random_token();
                  response.set_header("Content-Security-Policy", policy_of_page(nonce));
                  response.set_content(make(nonce), "text/html; charset=utf-8");
                });
}

void LocalServer::post(const std::string& path,
                       std::function<ServerAnswer(const std::string& body)> answer) {
  assert(path.starts_with('/'));
  library_->Post(path, [answer = std::move(answer)](const httplib::Request& request,
                                                    httplib::Response& response) {
    const ServerAnswer made = answer(request.body);
    response.status = made.status;
    response.set_header("Content-Security-Policy", policy_of_data);
    response.set_content(made.body, made.type);
  });
}

std::string LocalServer::address() const {
  return fmt::format("http://127.0.0.1:{}/?token={}", listener_.port, token_);
}

void LocalServer::run() {
  Connections connections(
      listener_, [this](const std::string& request) { return library_->answer_to(request); },
      refusal_text);
  listener_.socket = -1;
  if (connections.run(signals_, patience)) return;
  std::fflush(nullptr);
  std::_Exit(0);
}

}  // namespace flexopt

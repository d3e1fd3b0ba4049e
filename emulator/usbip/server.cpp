#include "emulator/usbip/server.hpp"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

namespace torsio::emulator::usbip {
namespace {

/// A client that does not read is not read from either, above this.
constexpr std::size_t kMostUnsent = 1U << 18;
constexpr std::size_t kReadSize = 1U << 14;

std::string text_of(const sockaddr_in& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
  return std::string(text.data()) + ":" + std::to_string(ntohs(address.sin_port));
}

void set_option(int socket, int level, int option) {
  const int on = 1;
  (void)setsockopt(socket, level, option, &on, sizeof on);
}

int open_listener(const std::string& address, std::uint16_t port) {
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(port);
  if (inet_pton(AF_INET, address.c_str(), &where.sin_addr) != 1) {
    throw CannotListen("\"" + address + "\" is not an IPv4 address such as 127.0.0.1");
  }
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (listener < 0) throw CannotListen(std::string("no socket: ") + std::strerror(errno));
  // Connections of a server that has just ended must not keep its port.
  set_option(listener, SOL_SOCKET, SO_REUSEADDR);
  if (bind(listener, reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0 &&
      listen(listener, 8) == 0) {
    return listener;
  }
  const int error = errno;
  close(listener);
  if (error == EADDRINUSE) {
    throw CannotListen("port " + std::to_string(port) +
                       " is in use, perhaps by another virtual knob; choose another port");
  }
  throw CannotListen("cannot listen on " + address + ", port " + std::to_string(port) + ": " +
                     std::strerror(error));
}

}  // namespace

Descriptor::~Descriptor() { close(number_); }

Server::Server(Export& exported, const std::string& address, std::uint16_t port,
               std::function<void(const std::string&)> tell)
    : export_(exported), tell_(std::move(tell)), listener_(open_listener(address, port)) {
  sockaddr_in where{};
  socklen_t size = sizeof where;
  (void)getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&where), &size);
  port_ = ntohs(where.sin_port);
}

bool Server::serve(std::chrono::nanoseconds timeout, int extra,
                   const std::function<void()>& awake) {
  std::vector<pollfd> watched{{listener_.get(), POLLIN, 0}, {extra, POLLIN, 0}};
  for (Connection& connection : connections_) {
    const std::size_t unsent = connection.session.output().size();
    int events = unsent > 0 ? POLLOUT : 0;
    if (unsent < kMostUnsent) events |= POLLIN;
    watched.push_back({connection.socket.get(), static_cast<short>(events), 0});
  }
  const auto seconds = std::chrono::floor<std::chrono::seconds>(timeout);
  const timespec wait{seconds.count(), (timeout - seconds).count()};
  const int ready = ppoll(watched.data(), watched.size(), &wait, nullptr);
  if (awake) awake();
  if (ready <= 0) return false;

  auto entry = watched.begin() + 2;
  for (Connection& connection : connections_) {
    const short events = (entry++)->revents;
    if ((events & (POLLIN | POLLERR | POLLHUP)) != 0) receive(connection);
    settle(connection);
  }
  remove_gone();
  if (watched[0].revents != 0) accept_all();
  return watched[1].revents != 0;
}

void Server::frame() {
  for (Connection& connection : connections_) {
    if (!connection.session.attached()) continue;
    connection.session.frame();
    settle(connection);
  }
  remove_gone();
}

void Server::disconnect() {
  for (Connection& connection : connections_) {
    connection.gone = connection.gone || connection.session.attached();
  }
  remove_gone();
}

void Server::accept_all() {
  while (true) {
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    const int socket = accept4(listener_.get(), reinterpret_cast<sockaddr*>(&peer), &size,
                               SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    // Small messages that the other side waits for.
    set_option(socket, IPPROTO_TCP, TCP_NODELAY);
    // A peer on another machine may vanish without a word.
    set_option(socket, SOL_SOCKET, SO_KEEPALIVE);
    if (connections_.size() >= kMostConnections) {
      const auto idle = std::ranges::find_if(
          connections_, [](const Connection& old) { return !old.session.attached(); });
      connections_.erase(idle);
    }
    connections_.emplace_back(socket, text_of(peer), export_);
  }
}

void Server::receive(Connection& connection) {
  std::array<std::uint8_t, kReadSize> bytes;
  const ssize_t count = recv(connection.socket.get(), bytes.data(), bytes.size(), 0);
  if (count > 0) {
    connection.session.receive(std::span(bytes).first(static_cast<std::size_t>(count)));
  } else if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
    connection.gone = true;
  }
}

/// Sends waiting answers, and notes changes.
void Server::settle(Connection& connection) {
  if (connection.session.attached() && !connection.was_attached) {
    connection.was_attached = true;
    tell_("attached " + connection.peer);
  }
  send(connection);
  const Session& session = connection.session;
  // A client that breaks the rules gets nothing more, and cannot keep the device by not reading.
  if (!session.problem().empty()) connection.gone = true;
  if (session.finished() && connection.session.output().empty()) connection.gone = true;
}

void Server::send(Connection& connection) {
  Bytes& output = connection.session.output();
  std::size_t sent = 0;
  while (sent < output.size() && !connection.gone) {
    const ssize_t count =
        ::send(connection.socket.get(), output.data() + sent, output.size() - sent, MSG_NOSIGNAL);
    if (count > 0) {
      sent += static_cast<std::size_t>(count);
    } else if (errno == EAGAIN) {
      break;
    } else if (errno != EINTR) {
      connection.gone = true;
    }
  }
  output.erase(output.begin(), output.begin() + static_cast<std::ptrdiff_t>(sent));
}

void Server::remove_gone() {
  for (auto connection = connections_.begin(); connection != connections_.end();) {
    if (!connection->gone) {
      ++connection;
      continue;
    }
    const bool was_attached = connection->was_attached;
    const std::string_view problem = connection->session.problem();
    const std::string reason(problem.empty() ? "the connection has ended" : problem);
    connection = connections_.erase(connection);  // which pulls the plug
    if (was_attached) tell_("detached " + reason);
  }
}

}  // namespace torsio::emulator::usbip

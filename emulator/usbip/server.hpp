/// @file
/// The sockets of the USB/IP server: who has connected, and whose bytes are whose. One thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <stdexcept>
#include <string>

#include "emulator/usbip/session.hpp"

namespace torsio::emulator::usbip {

/// A file descriptor that is closed in the end.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

/// The address or the port cannot be had.
class CannotListen : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

class Server {
 public:
  /// Connections at a time; the oldest that has not imported the device makes room for a new one.
  static constexpr std::size_t kMostConnections = 16;

  /// @param address IPv4, as in "127.0.0.1"
  /// @param port    0 for any free one
  /// @param tell    gets a line for each arrival and departure: "attached ..." or "detached ..."
  /// @throws CannotListen
  Server(Export& exported, const std::string& address, std::uint16_t port,
         std::function<void(const std::string&)> tell);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

  /// Receives, answers and sends, then waits for more of it until `timeout` is over or one of
  /// `extra` can be read.
  /// @param extra a further file descriptor to wait for, or -1
  /// @param awake called behind the wait, before anything that has come is looked at
  /// @returns true if `extra` has something to read, or has ended
  bool serve(std::chrono::nanoseconds timeout, int extra = -1,
             const std::function<void()>& awake = {});

  /// One frame of 1 ms for the client that has the device.
  void frame();

  /// Hangs up on the client that has the device.
  void disconnect();

 private:
  struct Connection {
    Connection(int number, std::string name, Export& exported)
        : socket(number), peer(std::move(name)), session(exported) {}
    Descriptor socket;
    std::string peer;
    Session session;
    bool was_attached = false;
    bool gone = false;
  };

  void accept_all();
  void receive(Connection& connection);
  void send(Connection& connection);
  void settle(Connection& connection);
  void remove_gone();

  Export& export_;
  std::function<void(const std::string&)> tell_;
  Descriptor listener_;
  std::uint16_t port_ = 0;
  std::list<Connection> connections_;
};

}  // namespace torsio::emulator::usbip

#include <exception>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <thread>

#include "fast_client.hpp"

// dds_wire DOMAIN: a participant of Fast DDS for scripts. Reads commands, a line each:
//
//   pub TOPIC TYPE          publishes serialised messages, reliably
//   sub TOPIC TYPE          subscribes, reliably
//   match SECONDS           waits until every topic has a peer; prints "1", or "0"
//   send TOPIC SIZE         the message follows
//   acknowledged SECONDS    waits until all has arrived; prints "1", or "0"
//   take TOPIC              prints the number of messages so far, and each as SIZE, newline, bytes

namespace chasles::test {
namespace {

class Wire {
 public:
  explicit Wire(int domain) : client_(domain) {}

  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb;
    words >> verb;
    if (verb == "match" || verb == "acknowledged") {
      int within = 0;
      words >> within;
      const std::chrono::seconds seconds(within);
      std::cout << (verb == "match" ? match(seconds) : acknowledged(seconds)) << std::endl;
      return;
    }
    std::string topic;
    words >> topic;
    if (verb == "pub" || verb == "sub") {
      std::string type;
      words >> type;
      open(verb, {.name = topic, .type = type});
    } else if (verb == "send") {
      std::size_t size = 0;
      words >> size;
      send(topic, size);
    } else if (verb == "take") {
      take(topic);
    } else {
      throw std::runtime_error("unknown command: " + line);
    }
  }

 private:
  void open(const std::string& verb, const WireTopic& topic) {
    if (verb == "pub") {
      writers_[topic.name] = std::make_unique<FastWriter>(client_, topic, FastWriter::Options{});
    } else {
      readers_[topic.name] = std::make_unique<FastReader>(client_, topic, true);
    }
  }
  bool match(std::chrono::seconds within) const {
    const auto end = FastReader::Clock::now() + within;
    const auto all = [&] {
      bool matched = true;
      for (const auto& [name, writer] : writers_) matched = matched && writer->readers() > 0;
      for (const auto& [name, reader] : readers_) matched = matched && reader->writers() > 0;
      return matched;
    };
    while (!all() && FastReader::Clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return all();
  }
  bool acknowledged(std::chrono::seconds within) const {
    bool all = true;
    for (const auto& [name, writer] : writers_) all = all && writer->acknowledged(within);
    return all;
  }
  void send(const std::string& topic, std::size_t size) {
    std::string bytes(size, '\0');
    std::cin.read(bytes.data(), static_cast<std::streamsize>(size));
    writers_.at(topic)->write(std::move(bytes));
  }
  void take(const std::string& topic) {
    const auto messages = readers_.at(topic)->messages();
    std::cout << messages.size() << '\n';
    for (const auto& message : messages) {
      std::cout << message.bytes.size() << '\n' << message.bytes;
    }
    std::cout.flush();
  }

  FastClient client_;
  std::map<std::string, std::unique_ptr<FastWriter>> writers_;
  std::map<std::string, std::unique_ptr<FastReader>> readers_;
};

}  // namespace
}  // namespace chasles::test

int main(int argc, char** argv) {
  try {
    chasles::test::Wire wire(argc == 2 ? std::stoi(argv[1]) : -1);
    for (std::string line; std::getline(std::cin, line);) wire.obey(line);
  } catch (const std::exception& error) {
    std::cerr << "dds_wire: " << error.what() << '\n';
    return 1;
  }
}

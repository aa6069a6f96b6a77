// The server with good clients and with bad ones, over real sockets of this machine.
#include "tools/view/server.h"

#include <gtest/gtest.h>

#include <list>
#include <thread>

#include "common/core/random.h"
#include "tools/data/files/json.h"
#include "tools/view/client_queue.h"
#include "tools/view/test_client.h"

namespace gw::view {
namespace {

using foxglove::Topic;
using testing::TestClient;
using tools::Json;

foxglove::Message Make(Topic topic, std::string json) {
  return {topic, Utime{1'000}, std::make_shared<const std::string>(std::move(json))};
}

// A server in a thread of its own. What it publishes is made in that thread.
class Served {
 public:
  explicit Served(ServerOptions options = {}) {
    options.port = 0;
    Server::Source source;
    source.state = [](Topic topic) -> std::vector<foxglove::Message> {
      if (topic != Topic::kTrajectory) return {};
      return {Make(topic, R"({"state":true})")};
    };
    auto created = Server::Create(options, PageFiles::WithoutPage(), source);
    EXPECT_TRUE(created.ok());
    server_ = std::move(*created);
    server_->Every(Milliseconds(5), [this] {
      for (int i = 0; i < kPerRound; ++i) {
        server_->Publish(
            {Make(Topic::kPose, R"({"pose":1})"), Make(Topic::kLog, std::string(20'000, 'x'))});
      }
    });
    thread_ = std::thread([this] { server_->Run(); });
  }
  ~Served() { End(); }
  ServerCounters End() {
    if (thread_.joinable()) {
      server_->Stop();
      thread_.join();
    }
    return server_->counters();
  }
  uint16_t port() const { return server_->port(); }
  bool Serves() { return TestClient(port()).Get("/").find("200 OK") != std::string::npos; }

 private:
  static constexpr int kPerRound = 10;
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

constexpr char kSubscribe[] =
    R"({"op":"subscribe","subscriptions":[{"id":9,"channelId":2},{"id":5,"channelId":3}]})";

TEST(Server, ServesThePageAndNothingElse) {
  Served served;
  const std::string page = TestClient(served.port()).Get("/");
  EXPECT_NE(page.find("200 OK"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy"), std::string::npos);
  for (const char* target : {"/../../etc/passwd", "/..", "/%2e%2e/%2e%2e/etc/passwd", "/etc/passwd",
                             "/index.html/..", "//", "/\\..\\etc", "/index.html\\0"}) {
    const std::string answer = TestClient(served.port()).Get(target);
    EXPECT_EQ(answer.find("200 OK"), std::string::npos) << target;
    EXPECT_EQ(answer.find("root:"), std::string::npos) << target;
  }
  TestClient post(served.port());
  post.Send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
  EXPECT_NE(post.Receive().find("405"), std::string::npos);
  EXPECT_GE(served.End().refused_requests, 8);
}

TEST(Server, TellsAClientWhatItSubscribesTo) {
  Served served;
  TestClient client(served.port());
  ASSERT_NE(client.Upgrade().find("101"), std::string::npos);
  EXPECT_EQ(Json::parse(*client.NextFrame())["op"], "serverInfo");
  EXPECT_EQ(Json::parse(*client.NextFrame())["op"], "advertise");
  client.Send(TestClient::Frame(kSubscribe));
  bool state = false, pose = false;
  for (int i = 0; i < 50 && !(state && pose); ++i) {
    const auto frame = client.NextFrame();
    ASSERT_TRUE(frame);
    const auto subscription = static_cast<int>(static_cast<unsigned char>((*frame)[1]));
    state |= subscription == 5 && frame->substr(13) == R"({"state":true})";
    pose |= subscription == 9 && frame->substr(13) == R"({"pose":1})";
  }
  EXPECT_TRUE(state);
  EXPECT_TRUE(pose);
}

TEST(Server, RefusesForeignPagesNamesAndMissingTokens) {
  ServerOptions options;
  options.access.token = "0123456789abcdef";
  Served served(options);
  const std::string protocol = TestClient::kProtocol;
  EXPECT_NE(TestClient(served.port()).Upgrade("/").find("403"), std::string::npos);
  EXPECT_NE(TestClient(served.port())
                .Upgrade("/?token=0123456789abcdef", protocol + "Origin: http://evil.example\r\n")
                .find("403"),
            std::string::npos);
  EXPECT_NE(TestClient(served.port())
                .Upgrade("/?token=0123456789abcdef", protocol, "evil.example")
                .find("421"),
            std::string::npos);
  EXPECT_NE(TestClient(served.port()).Upgrade("/?token=0123456789abcdef", "").find("400"),
            std::string::npos);
  EXPECT_NE(TestClient(served.port()).Upgrade("/?token=0123456789abcdef").find("101"),
            std::string::npos);
  EXPECT_EQ(served.End().refused_requests, 4);
}

TEST(Server, SurvivesGarbage) {
  Served served;
  CounterRng rng(7, 0, 0);
  for (int i = 0; i < 200; ++i) {
    TestClient client(served.port());
    std::string garbage(1 + rng.Below(2000), ' ');
    for (char& c : garbage) c = static_cast<char>(rng.Below(256));
    client.Send(garbage + "\r\n\r\n");
  }
  for (int i = 0; i < 200; ++i) {
    TestClient client(served.port());
    client.Upgrade();
    std::string garbage(1 + rng.Below(200), ' ');
    for (char& c : garbage) c = static_cast<char>(rng.Below(256));
    client.Send(garbage);
  }
  TestClient header(served.port());
  header.Send("GET / HTTP/1.1\r\nX: " + std::string(100'000, 'x') + "\r\n\r\n");
  EXPECT_TRUE(header.IsClosed());
  EXPECT_TRUE(served.Serves());
  EXPECT_GT(served.End().refused_requests, 100);
}

TEST(Server, ClosesOnOversizedAndOnManyMalformedMessages) {
  Served served;
  TestClient large(served.port());
  large.Upgrade();
  large.Send(TestClient::Frame(std::string(200'000, ' ')));
  EXPECT_TRUE(large.IsClosed());
  TestClient stubborn(served.port());
  stubborn.Upgrade();
  for (int i = 0; i < 50; ++i) stubborn.Send(TestClient::Frame("nonsense", 1 + i % 2));
  EXPECT_TRUE(stubborn.IsClosed());
  EXPECT_TRUE(served.Serves());
  const ServerCounters counters = served.End();
  EXPECT_EQ(counters.clients_dropped, 2);
  EXPECT_GT(counters.malformed_messages, 20);
}

TEST(Server, TenThousandConnectionsOpenedAndDropped) {
  Served served;
  for (int i = 0; i < 10'000; ++i) {
    TestClient client(served.port());
    ASSERT_TRUE(client.connected()) << i;
    if (i % 3 == 0) client.Send("GET / HT");
  }
  EXPECT_TRUE(served.Serves());
  EXPECT_GE(served.End().connections, 10'000);
}

TEST(Server, ConnectionsAreLimitedAndSilentOnesEnd) {
  ServerOptions options;
  options.max_connections = 8;
  options.request_timeout = Milliseconds(300);
  Served served(options);
  std::list<TestClient> silent;
  for (int i = 0; i < 8; ++i) silent.emplace_back(served.port());
  EXPECT_TRUE(TestClient(served.port()).IsClosed());
  for (TestClient& client : silent) EXPECT_TRUE(client.IsClosed());
  EXPECT_TRUE(served.Serves());
  EXPECT_GE(served.End().refused_full, 1);
}

TEST(Server, AStalledClientDoesNotHinderOthers) {
  ServerOptions options;
  options.idle_timeout = Milliseconds(600);
  Served served(options);
  const std::string all =
      R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":2},{"id":2,"channelId":14}]})";
  TestClient stalled(served.port());
  stalled.Upgrade();
  stalled.Send(TestClient::Frame(all));  // and reads no more
  TestClient good(served.port());
  good.Upgrade();
  good.Send(TestClient::Frame(kSubscribe));
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(good.NextFrame());
    good.Send(TestClient::Frame("", 10));  // a pong: it lives
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  EXPECT_TRUE(served.Serves());
  const ServerCounters counters = served.End();
  EXPECT_GT(counters.messages_dropped, 100);
  EXPECT_GE(counters.clients_dropped, 1);  // it did not answer pings
}

TEST(Server, AnAddressInUseIsAnError) {
  Served served;
  ServerOptions options;
  options.port = served.port();
  EXPECT_FALSE(Server::Create(options, PageFiles::WithoutPage(), {}).ok());
  options.address = "no address";
  EXPECT_FALSE(Server::Create(options, PageFiles::WithoutPage(), {}).ok());
}

}  // namespace
}  // namespace gw::view

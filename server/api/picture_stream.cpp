#include <memory>
#include <utility>

#include "server/api/api.h"
#include "server/api/problem.h"
#include "server/jobs/job.h"

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{1000};  // how soon a closed connection is noticed
constexpr std::chrono::seconds kRepeat{15};       // keeps proxies from taking silence for death
constexpr const char* kBoundary = "photond-picture";

/// A picture as a part of the stream, twice: Chromium shows a part only when the next one begins.
std::string twice(const std::vector<std::byte>& jpeg) {
  std::string part = std::string("--") + kBoundary + "\r\nContent-Type: image/jpeg\r\nContent-Length: " +
                     std::to_string(jpeg.size()) + "\r\n\r\n";
  part.append(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  part += "\r\n";
  return part + part;
}

/// One viewer's place: the newest picture that it was sent. A slow one skips pictures and delays nobody.
class PictureFeed {
 public:
  PictureFeed(const Store& store, const Jobs& jobs, std::string id, std::stop_token stop)
      : store_(store), jobs_(jobs), id_(std::move(id)), watched_(jobs.job(id_)), stop_(std::move(stop)) {}

  std::optional<std::string> next() {
    if (ended_) return std::nullopt;
    if (watched_) watched_->look();
    const std::uint64_t seen = jobs_.events().newest();
    std::string text = newest();
    if (!text.empty() || ended_) return text;
    if (jobs_.events().wait_beyond(seen, kLook, stop_)) text = newest();
    if (text.empty() && sent_ && Clock::now() - last_ >= kRepeat) text = send(sent_);
    return text;
  }

 private:
  /// The newest picture where it was not sent yet; the end where the job has ended.
  std::string newest() {
    const auto job = store_.job(id_);
    std::string text;
    if (job && job->revision > revision_) {
      // One that is superseded meanwhile is not kept: the next look finds its successor.
      if (const auto jpeg = jobs_.frame(id_, job->revision, FrameFormat::jpg); jpeg) {
        revision_ = job->revision;
        text = send(*jpeg);
      }
    }
    ended_ = !job || is_terminal(job->state);
    if (ended_) text += std::string("--") + kBoundary + "--\r\n";
    return text;
  }

  std::string send(const Frames::Bytes& jpeg) {
    last_ = Clock::now();
    sent_ = jpeg;
    return twice(*jpeg);
  }

  const Store& store_;
  const Jobs& jobs_;
  const std::string id_;
  const std::shared_ptr<const Job> watched_;
  std::stop_token stop_;
  std::uint32_t revision_ = 0;
  Frames::Bytes sent_;
  Clock::time_point last_ = Clock::now();
  bool ended_ = false;
};

}  // namespace

Response Api::picture_stream(const Request& request) const {
  const std::string& id = request.captures[0];
  if (!store_.job(id)) return no_job(id);
  Response response;
  response.content_type = std::string("multipart/x-mixed-replace; boundary=") + kBoundary;
  response.headers.emplace_back("Cache-Control", "no-store");
  response.headers.emplace_back("X-Accel-Buffering", "no");
  response.body = Pieces([feed = std::make_shared<PictureFeed>(store_, jobs_, id, request.stop)] { return feed->next(); });
  return response;
}

}  // namespace photond

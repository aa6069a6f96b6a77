#include "tools/robot/navigate/run_record.h"

#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace gw::navigate {

Result<RunRecord> RunRecord::Create(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  const auto open = [&folder](const char* name) {
    return File(std::fopen((folder + "/" + name).c_str(), "w"), std::fclose);
  };
  RunRecord record(folder, open("stops.csv"), open("plan.csv"), open("pose.tum"));
  if (!record.stops_ || !record.plan_ || !record.poses_) {
    return Error{ErrorCode::kIo, folder + ": cannot be written: " + std::strerror(errno)};
  }
  std::fputs("utime,stop,waypoint,status,x_plan,y_plan,yaw_plan,x,y,yaw,sigma_m\n",
             record.stops_.get());
  std::fputs("stop,x,y\n", record.plan_.get());
  return record;
}

void RunRecord::AddStop(const Event& event, int waypoint, const floorplan::Waypoint& place) {
  std::fprintf(stops_.get(), "%" PRId64 ",%d,%d,%s,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n",
               event.pose.utime.us, event.stop, waypoint, EventName(event.kind), place.position.x(),
               place.position.y(), place.yaw, event.pose.position.x(), event.pose.position.y(),
               event.pose.yaw, event.pose.sigma_m);
  std::fflush(stops_.get());
}

void RunRecord::AddLeg(int stop, const floorplan::Leg& leg) {
  for (const Eigen::Vector2d& p : leg) {
    std::fprintf(plan_.get(), "%d,%.4f,%.4f\n", stop, p.x(), p.y());
  }
  std::fflush(plan_.get());
}

void RunRecord::AddPose(const RobotPose& pose) {
  std::fprintf(poses_.get(), "%.6f %.6f %.6f 0 0 0 %.9f %.9f\n", pose.utime.seconds(),
               pose.position.x(), pose.position.y(), std::sin(0.5 * pose.yaw),
               std::cos(0.5 * pose.yaw));
}

void RunRecord::SetSummary(const std::string& text) {
  std::ofstream out(folder_ + "/summary.txt");
  out << text << std::endl;
  summary_good_ = out.good();
}

Result<Done> RunRecord::Close() {
  bool good = summary_good_;
  for (File* file : {&stops_, &plan_, &poses_}) {
    good = std::fflush(file->get()) == 0 && std::ferror(file->get()) == 0 && good;
  }
  if (!good) return Error{ErrorCode::kIo, folder_ + ": could not be written; is the disk full?"};
  return Done{};
}

}  // namespace gw::navigate

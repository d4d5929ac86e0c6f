#include "server/jobs/environment_library.h"

#include <chrono>
#include <string_view>
#include <utility>

#include "server/jobs/take_turn.h"
#include "server/store/file.h"

namespace photond {

namespace {

std::string media_type_of(const std::vector<std::byte>& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("#?") ? "image/vnd.radiance" : "image/x-exr";
}

}  // namespace

Result<EnvironmentLibrary::Added> EnvironmentLibrary::add(std::vector<std::byte> bytes, const std::string& name,
                                                          const Owner& owner, std::stop_token stop) {
  const Digest id = sha256(bytes);
  auto known = store_.find(id);
  if (!known) return known.error();
  if (*known) {
    if (!(*known)->name.empty() || name.empty() || !owner.may_change((*known)->owner)) return Added{**known, false};
    if (const Status named = store_.name(id, name); !named) return named.error();
    (*known)->name = name;
    return Added{**known, false};
  }
  const auto decoded = decoded_.get_or_build(id, [&] { return decode(bytes, stop); }, stop);
  if (!decoded) return decoded.error();
  const EnvironmentMap& map = *decoded->value->map;
  EnvironmentRecord record{id,           media_type_of(bytes), bytes.size(), map.width(), map.height(),
                           map.warnings, std::chrono::system_clock::now(), owner.key, name};
  if (const Status room = room_.make_room(bytes.size()); !room) return room.error();
  if (const Status put = store_.put(record, bytes, owner.limits.bytes); !put) return put.error();
  return Added{std::move(record), true};
}

Result<EnvironmentRecord> EnvironmentLibrary::find(const Digest& id) const {
  auto found = store_.find(id);
  if (!found) return found.error();
  if (!*found) return Error{ErrorCode::not_found, "there is no environment of this id", ""};
  return std::move(**found);
}

Result<Environment> EnvironmentLibrary::environment(const EnvironmentChoice& choice, std::stop_token stop) {
  const auto record = find(choice.id);
  if (!record && is_disk_unreachable(record.error())) return record.error();
  if (!record) return Error{record.error().code, record.error().message, "/environment/id"};
  const auto build = [&]() -> Result<std::shared_ptr<const Decoded>> {
    const Result<Blob> bytes = store_.bytes(choice.id);
    if (!bytes && is_disk_unreachable(bytes.error())) return bytes.error();
    if (!bytes) return Error{bytes.error().code, bytes.error().message, "/environment/id"};
    return decode(**bytes, stop);
  };
  const auto decoded = decoded_.get_or_build(choice.id, build, stop);
  if (!decoded) return decoded.error();
  return Environment{.radiance = Rgb(choice.scale),
                     .map = decoded->value->map,
                     .rotation = glm::radians(choice.rotation_deg)};
}

Result<std::shared_ptr<const EnvironmentLibrary::Decoded>> EnvironmentLibrary::decode(
    const std::vector<std::byte>& bytes, const std::stop_token& stop) {
  const auto turn = take_turn(decoding_, stop);
  if (!turn) return cancelled();
  auto map = read_environment(bytes);
  if (!map) return map.error();
  const std::uint64_t size = sizeof(Decoded) + (*map)->memory_bytes();
  return std::make_shared<const Decoded>(Decoded{std::move(*map), size});
}

}  // namespace photond

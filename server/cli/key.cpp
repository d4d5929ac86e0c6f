#include <ctime>
#include <iomanip>
#include <iostream>

#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/printable.h"
#include "server/store/keys.h"

namespace photond {

namespace {

std::string date_of(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d", &parts);
  return text;
}

bool has_folder(const KeyFile& file) {
  std::error_code failure;
  return std::filesystem::is_directory(file.path().parent_path(), failure);
}

int tell_missing_folder(const std::string& subject, const KeyFile& file) {
  const std::string folder = file.path().parent_path().string();
  return print_failure(subject, {ErrorCode::not_found, "there is no folder " + folder, {}});
}

int create(const KeyFile& file, const KeyCommand& command) {
  const auto scope = scope_from_name(command.scope);
  if (!scope) return print_usage_error("--scope expects read, submit or admin");
  const Result<NewKey> key = make_key(*scope, command.limits, command.label);
  if (!key) return print_usage_error(key.error().message);
  const bool is_new = !has_folder(file);  // keys may be made before the service is started for the first time
  const Status added = file.add(key->record, [&key] {
    std::cout << key->secret << '\n';
    return flush_output();
  });
  if (!added) return print_failure("the key is not stored", added.error());
  if (is_new) {
    std::cerr << printable("photond: the folder " + file.path().parent_path().string() + " was not there and is made") + "\n";
  }
  std::cerr << "photond: key " << key->record.id << " may " << scope_name(*scope)
            << "; it is shown this once, only its SHA-256 is kept\n";
  return kExitOk;
}

int list(const KeyFile& file) {
  if (!has_folder(file)) return tell_missing_folder("cannot read the keys", file);
  const Result<std::vector<KeyRecord>> keys = file.read();
  if (!keys) return print_failure("cannot read the keys", keys.error());
  for (const KeyRecord& key : *keys) {
    std::cout << key.id << "  " << std::left << std::setw(6) << scope_name(key.scope) << "  " << date_of(key.created);
    if (key.limits.jobs) std::cout << "  jobs " << *key.limits.jobs;
    if (key.limits.bytes) std::cout << "  MB " << (*key.limits.bytes >> 20);
    if (key.limits.streams) std::cout << "  streams " << *key.limits.streams;
    std::cout << (key.label.empty() ? "" : "  ") << key.label << '\n';
  }
  return finish_output();
}

int revoke(const KeyFile& file, const std::string& id) {
  if (!has_folder(file)) return tell_missing_folder("cannot revoke", file);
  if (const Status revoked = file.revoke(id); !revoked) return print_failure("cannot revoke", revoked.error());
  return kExitOk;
}

}  // namespace

int run_key(const KeyCommand& command) {
  if (command.data.empty()) return print_usage_error("there is no home folder; name the service's with --data");
  const KeyFile file{std::filesystem::path(command.data)};
  if (command.action == KeyCommand::Action::create) return create(file, command);
  return command.action == KeyCommand::Action::list ? list(file) : revoke(file, command.id);
}

}  // namespace photond

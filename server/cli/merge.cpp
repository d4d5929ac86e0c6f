#include <algorithm>
#include <iostream>

#include "core/film/error.h"
#include "core/render/note.h"
#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"
#include "server/cli/picture.h"
#include "server/cli/progress.h"
#include "server/cli/report_json.h"
#include "server/store/accumulator.h"

namespace photond {
namespace {

Error about(const std::string& file, Error error) {
  error.message = file + ": " + error.message;
  return error;
}

/// Whether the film has the size that the identity states.
bool has_stated_size(const Film& film, const Json& identity) {
  const Json::json_pointer width("/settings/width"), height("/settings/height");
  return identity.contains(width) && identity.contains(height) && identity[width] == film.width &&
         identity[height] == film.height;
}

/// An accumulator whose identity is read.
struct Input {
  Json identity;
  Film film;
};

Result<Input> read_input(const std::string& file) {
  constexpr std::uint64_t kMaxBytes = 1ull << 38;  // 16384² pixels of about 500 bytes, 48 more for each open block
  const auto bytes = read_file(file, kMaxBytes);
  if (!bytes) return about(file, bytes.error());
  auto accumulator = read_accumulator(*bytes);
  if (!accumulator) return about(file, accumulator.error());
  auto identity = parse_json(std::as_bytes(std::span(accumulator->identity)));
  if (!identity) return invalid_input(file + ": is damaged: its identity is " + identity.error().message);
  if (!has_stated_size(accumulator->film, *identity)) {
    return invalid_input(file + ": is damaged: its film has not the size it states");
  }
  if (accumulator->film.passes.empty()) return invalid_input(file + ": holds no passes");
  return Input{std::move(*identity), std::move(accumulator->film)};
}

/// The files joined so far, and who brought which passes.
struct Merged {
  Input joined;
  struct Part {
    PassRange passes;
    std::string file;
  };
  std::vector<Part> parts;
};

Status check_overlap(const Merged& merged, const std::string& file, const Film& film) {
  for (const Merged::Part& part : merged.parts) {
    for (const PassRange& range : film.passes) {
      const std::uint32_t first = std::max(part.passes.first, range.first);
      const std::uint32_t last = std::min(part.passes.last, range.last);
      if (first >= last) continue;
      return invalid_input(file + ": contains passes " + std::to_string(first) + ":" + std::to_string(last) +
                           ", which " + part.file + " contains as well");
    }
  }
  return Done{};
}

Status add_input(Merged& merged, const std::string& file, const std::string& first_file) {
  auto input = read_input(file);
  if (!input) return input.error();
  const std::string difference = first_difference(merged.joined.identity, input->identity);
  if (!difference.empty() || merged.joined.identity != input->identity) {
    return invalid_input(file + ": belongs to another picture than " + first_file + ": " + difference + " differs");
  }
  if (const Status apart = check_overlap(merged, file, input->film); !apart) return apart;
  for (const PassRange& range : input->film.passes) merged.parts.push_back({range, file});
  return merge_film(merged.joined.film, input->film);
}

/// Fails where the passes do not start at 0 or have a hole.
Status check_complete(Merged& merged) {
  std::sort(merged.parts.begin(), merged.parts.end(),
            [](const Merged::Part& a, const Merged::Part& b) { return a.passes.first < b.passes.first; });
  std::uint32_t next = 0;
  for (const Merged::Part& part : merged.parts) {
    if (part.passes.first != next) {
      return invalid_input(part.file + ": starts at pass " + std::to_string(part.passes.first) + ", but the passes " +
                           std::to_string(next) + ":" + std::to_string(part.passes.first) + " are missing");
    }
    next = part.passes.last;
  }
  return Done{};
}

Result<Merged> merge_inputs(const std::vector<std::string>& inputs) {
  auto first = read_input(inputs[0]);
  if (!first) return first.error();
  Merged merged{std::move(*first), {}};
  for (const PassRange& range : merged.joined.film.passes) merged.parts.push_back({range, inputs[0]});
  for (std::size_t i = 1; i < inputs.size(); ++i) {
    if (const Status added = add_input(merged, inputs[i], inputs[0]); !added) return added.error();
  }
  if (const Status complete = check_complete(merged); !complete) return complete.error();
  return merged;
}

Json merge_json(const MergeCommand& command, const Input& joined) {
  Json json = joined.identity;
  json["inputs"] = command.inputs;
  json["outputs"] = command.outputs;
  json["passes"] = joined.film.pass_count();
  json["rejected_samples"] = joined.film.rejected;
  json["truncated_paths"] = joined.film.truncated;
  json["error"] = error_json(joined.film, estimate_error(joined.film));
  return json;
}

}  // namespace

int run_merge(const MergeCommand& command) {
  const Interrupt interrupt(Interrupt::Ends::at_first);
  if (const int code = check_pictures(command.outputs, command.report, command.inputs); code != kExitOk) return code;
  const auto merged = merge_inputs(command.inputs);
  if (!merged) return print_failure("cannot merge", merged.error());
  const Film& film = merged->joined.film;
  const Json& identity = merged->joined.identity;
  const bool biased = identity.value(Json::json_pointer("/plan/biased"), Json(false)) == true;
  const Json stated = identity.value(Json::json_pointer("/plan/method"), Json());
  const std::string method = stated.is_string() ? stated.get<std::string>() : "";
  for (const std::string& output : command.outputs) {
    if (const auto written = write_picture(output, film, picture_note(method, biased)); !written) return print_failure(output, written.error());
  }
  if (!command.report.empty()) {
    const std::string text = indented(merge_json(command, merged->joined));
    const auto written = write_file(command.report, std::as_bytes(std::span(text)));
    if (!written) return print_failure(command.report, written.error());
  }
  std::string text = "merged " + std::to_string(film.pass_count()) + " passes" +
                     error_text(estimate_error(film), biased) + losses_text(film) + " ->";
  for (const std::string& output : command.outputs) text += " " + output;
  std::cerr << text + "\n";
  return kExitOk;
}

}  // namespace photond

#include "server/store/map_key_text.h"

#include <charconv>

namespace photond {

namespace {

constexpr std::string_view kCaustic = "-caustic";

// Takes a whole number up to the next '-' or the end.
template <class Number>
bool take(std::string_view& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool take_dash(std::string_view& text) {
  if (!text.starts_with('-')) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::string key_text(const MapKey& key) {
  return to_hex(key.scene) + "-" + std::to_string(key.settings.photons_per_pass) + "-" +
         std::to_string(key.settings.seed) + "-" + std::to_string(key.pass) +
         (key.set == PhotonSet::caustic ? std::string(kCaustic) : "");
}

std::optional<MapKey> parse_key(std::string_view text) {
  constexpr std::size_t kDigits = 64;
  const auto scene = digest_from_hex(text.substr(0, kDigits));
  if (!scene) return std::nullopt;
  MapKey key{.scene = *scene};
  std::string_view rest = text.substr(kDigits);
  const bool numbers = take_dash(rest) && take(rest, key.settings.photons_per_pass) && take_dash(rest) &&
                       take(rest, key.settings.seed) && take_dash(rest) && take(rest, key.pass);
  if (rest == kCaustic) {
    key.set = PhotonSet::caustic;
    rest = {};
  }
  // One key, one name: no leading zeros.
  if (!numbers || !rest.empty() || key_text(key) != text) return std::nullopt;
  return key;
}

}  // namespace photond

#include "server/api/authorize.h"

#include <algorithm>
#include <cctype>

#include "server/api/contract.h"
#include "server/api/problem.h"

namespace photond {

namespace {

/// A refusal that tells a client how to ask, by RFC 6750.
Response challenge(int status, const char* code, const std::string& detail, const std::string& error) {
  Response response = problem(status, code, detail);
  response.headers.emplace_back("WWW-Authenticate", "Bearer realm=\"photond\"" + (error.empty() ? "" : ", " + error));
  return response;
}

/// What stands behind `Bearer `; empty where there is no such header.
std::string secret_of(const Request& request) {
  const std::string field = request.header("authorization");
  static constexpr std::string_view kScheme = "bearer ";
  const bool bearer = field.size() > kScheme.size() &&
                      std::equal(kScheme.begin(), kScheme.end(), field.begin(),
                                 [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
  return bearer ? field.substr(kScheme.size()) : std::string();
}

}  // namespace

std::optional<Response> authorize(const Keyring& keys, const Operation& operation, Request& request) {
  request.caller = {};
  if (!operation.scope || !keys.required()) return std::nullopt;
  const std::string secret = secret_of(request);
  if (secret.empty()) return challenge(401, "unauthorized", "this needs a key: Authorization: Bearer photond_…", "");
  const Result<std::optional<KeyRecord>> key = keys.find(secret);
  if (!key) return problem(503, "io", "the keys cannot be read");
  if (!*key) return challenge(401, "unauthorized", "this key is not known, or was revoked", "error=\"invalid_token\"");
  if ((*key)->scope < *operation.scope) {
    const std::string scope = scope_name(*operation.scope);
    return challenge(403, "forbidden", "this needs a key of scope " + scope,
                     "error=\"insufficient_scope\", scope=\"" + scope + "\"");
  }
  request.caller = {(*key)->id, (*key)->scope, (*key)->limits};
  return std::nullopt;
}

std::shared_ptr<void> OpenStreams::take(const Caller& caller) {
  const std::lock_guard lock(counts_->mutex);
  std::uint64_t& open = counts_->open[caller.key];
  if (caller.limits.streams && open >= *caller.limits.streams) return nullptr;
  ++open;
  return std::shared_ptr<void>(this, [counts = counts_, key = caller.key](void*) {
    const std::lock_guard unlock(counts->mutex);
    if (--counts->open[key] == 0) counts->open.erase(key);
  });
}

}  // namespace photond

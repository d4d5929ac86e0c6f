#include "tests/server/contract_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "server/api/contract.h"
#include "server/api/openapi.h"
#include "server/http/route_table.h"

namespace photond::test {

namespace {

const Contract& contract() {
  static const Contract kContract = std::move(*Contract::read(kOpenApiText));
  return kContract;
}

/// As the server finds it: a literal ending (`.glb`) goes before a placeholder alone.
const Operation* operation_of(const std::string& method, const std::string& path) {
  const Operation* found = nullptr;
  for (const Operation& operation : contract().operations()) {
    if (operation.method != (method == "HEAD" ? "GET" : method) || !match_path(operation.pattern, path)) continue;
    if (found == nullptr || operation.pattern.size() > found->pattern.size()) found = &operation;
  }
  return found;
}

const Answer* answer_of(const Operation& operation, int status) {
  const auto exact = operation.answers.find(std::to_string(status));
  if (exact != operation.answers.end()) return &exact->second;
  const auto other = operation.answers.find("default");
  return other == operation.answers.end() || status < 400 ? nullptr : &other->second;
}

std::string header_of(const Reply& reply, const std::string& name) {
  const auto found = reply.headers.find(name);
  return found == reply.headers.end() ? std::string() : found->second;
}

void expect_headers(const Answer& answer, const Reply& reply, const std::string& what) {
  std::set<std::string> announced;
  for (const auto& [name, schema] : answer.headers) {
    std::string lower = name;
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
    announced.insert(lower);
  }
  for (const char* name : {"etag", "location", "content-location", "retry-after", "photond-revision", "www-authenticate",
                           "idempotency-replayed"}) {
    EXPECT_TRUE(!reply.headers.contains(name) || announced.contains(name)) << what << " has " << name;
  }
}

void expect_body(const Answer& answer, const Reply& reply, const std::string& what) {
  const std::string type = header_of(reply, "content-type").substr(0, header_of(reply, "content-type").find(';'));
  if (answer.content.empty()) {
    EXPECT_EQ(reply.body, "") << what;
    return;
  }
  const auto media = answer.content.find(type);
  ASSERT_NE(media, answer.content.end()) << what << " is " << type;
  if (!type.ends_with("json")) return;
  const Json body = Json::parse(reply.body, nullptr, false);
  ASSERT_FALSE(body.is_discarded()) << what;
  for (const Violation& violation : check_value(*media->second, body)) ADD_FAILURE() << what << ": " << violation.detail;
}

}  // namespace

void expect_contract_kept(const std::string& method, const std::string& target, const Reply& reply) {
  const Operation* operation = operation_of(method, target.substr(0, target.find('?')));
  if (operation == nullptr || reply.status == 0) return;  // not part of the contract, or no answer
  const std::string what = method + " " + target + " -> " + std::to_string(reply.status);
  const Answer* answer = answer_of(*operation, reply.status);
  ASSERT_NE(answer, nullptr) << what << " is not in the contract";
  expect_headers(*answer, reply, what);
  if (method != "HEAD") expect_body(*answer, reply, what);
}

}  // namespace photond::test

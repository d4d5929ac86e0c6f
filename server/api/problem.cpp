#include "server/api/problem.h"

#include "server/api/json.h"

namespace photond {

namespace {

constexpr const char* kIfMatch = "If-Match";

const char* title_of(int status) {
  switch (status) {
    case 400:
      return "Bad request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not found";
    case 405:
      return "Method not allowed";
    case 409:
      return "Conflict";
    case 411:
      return "Length required";
    case 412:
      return "Precondition failed";
    case 413:
      return "Content too large";
    case 414:
      return "URI too long";
    case 415:
      return "Unsupported media type";
    case 416:
      return "Range not satisfiable";
    case 417:
      return "Expectation failed";
    case 422:
      return "Unprocessable content";
    case 429:
      return "Too many requests";
    case 431:
      return "Request header fields too large";
    case 500:
      return "Internal error";
    case 501:
      return "Not implemented";
    case 503:
      return "Unavailable";
    case 505:
      return "HTTP version not supported";
    case 507:
      return "Insufficient storage";
    default:
      return "Error";
  }
}

int status_of(const Error& error) {
  switch (error.code) {
    case ErrorCode::invalid_input:
      return 422;
    case ErrorCode::unsupported:
      return 422;
    case ErrorCode::limit_exceeded:
      if (error.where == "disk") return 507;
      return error.where == "queue" ? 429 : 422;
    case ErrorCode::not_found:
      return error.where.empty() ? 404 : 422;  // with a place: something the body names
    case ErrorCode::conflict:
      return 409;
    case ErrorCode::cancelled:
      return 503;
    case ErrorCode::io:
      return 503;
    case ErrorCode::internal:
      return 500;
  }
  return 500;
}

}  // namespace

const char* error_name(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_input:
      return "invalid_input";
    case ErrorCode::unsupported:
      return "unsupported";
    case ErrorCode::limit_exceeded:
      return "limit_exceeded";
    case ErrorCode::not_found:
      return "not_found";
    case ErrorCode::conflict:
      return "conflict";
    case ErrorCode::io:
      return "io";
    case ErrorCode::cancelled:
      return "cancelled";
    case ErrorCode::internal:
      return "internal";
  }
  return "internal";
}

Response problem(int status, const std::string& code, const std::string& detail, const std::string& pointer) {
  return problem(status, code, {{pointer, detail}});
}

Response problem(int status, const std::string& code, const std::vector<Violation>& violations) {
  Json body{{"type", "about:blank"},
            {"title", title_of(status)},
            {"status", status},
            {"code", code},
            {"detail", violations.front().detail}};
  if (!violations.front().where.empty()) body["pointer"] = violations.front().where;
  if (violations.size() > 1) {
    for (const Violation& violation : violations)
      body["errors"].push_back({{"pointer", violation.where}, {"detail", violation.detail}});
  }
  Response response;
  response.status = status;
  response.refusal = code;
  response.content_type = "application/problem+json";
  response.headers.emplace_back("Cache-Control", "no-store");
  if (status == 429 || status == 503) response.headers.emplace_back("Retry-After", "2");
  response.body = to_text(body);
  return response;
}

Response no_job(const std::string& id) { return problem(404, "not_found", "there is no job " + id); }

std::optional<Response> failed_ownership(const Request& request, const std::string& owner) {
  if (request.caller.may_change(owner)) return std::nullopt;
  return problem(403, "not_yours", "this came with another key; only that one, or one of scope admin, may change it");
}

Error failed_match() { return invalid_input("this is not the version that If-Match names any more", kIfMatch); }

Response problem(const Error& error) {
  if (error.where == kIfMatch) return problem(412, "changed", error.message, error.where);
  return problem(status_of(error), error_name(error.code), error.message, error.where);
}

}  // namespace photond

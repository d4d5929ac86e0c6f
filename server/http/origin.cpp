#include "server/http/origin.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace photond {

namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

/// A host without its port; an IPv6 address with its brackets.
std::string_view name_of(std::string_view host) {
  const std::size_t bracket = host.starts_with('[') ? host.find(']') : std::string_view::npos;
  return host.substr(0, bracket == std::string_view::npos ? host.find(':') : bracket + 1);
}

bool is_address(std::string_view name) {
  const bool bracketed = name.starts_with('[') && name.ends_with(']');
  const std::string text(bracketed ? name.substr(1, name.size() - 2) : name);
  in6_addr address{};
  return inet_pton(bracketed ? AF_INET6 : AF_INET, text.c_str(), &address) == 1;
}

bool is_of_this_machine(std::string_view name) {
  if (name.ends_with('.')) name.remove_suffix(1);
  return name == "localhost" || name.ends_with(".localhost");
}

/// `https://example.org:8443` without its scheme; empty where it is not of that kind.
std::string_view host_of(std::string_view origin) {
  const std::size_t scheme = origin.find("://");
  return scheme == std::string_view::npos ? std::string_view() : origin.substr(scheme + 3);
}

/// Proxies may pass on a host without the port that the browser sees.
bool is_same(std::string_view origin, std::string_view host) {
  const std::string_view own = host_of(origin);
  return !own.empty() && (own == host || (name_of(own) == host && name_of(host) == host));
}

}  // namespace

std::optional<std::string> refuse_origin(const Head& head, const Cors& cors, bool any_host) {
  const std::string host = lower(head.field("host"));
  const std::string_view name = name_of(host);
  if (!any_host && !host.empty() && !is_address(name) && !is_of_this_machine(name)) {  // browsers always say one
    const std::vector<std::string>& sites = cors.origins();
    const bool named = std::any_of(sites.begin(), sites.end(),
                                   [&](const std::string& site) { return name_of(host_of(site)) == name; });
    if (!named) return "the service answers to this name only where keys are required";
  }
  if (head.method == "GET" || head.method == "HEAD" || cors.allows(head)) return std::nullopt;
  const std::string site = lower(head.field("sec-fetch-site"));
  const std::string origin = lower(head.field("origin"));
  if ((!site.empty() && site != "same-origin" && site != "none") || (!origin.empty() && !is_same(origin, host))) {
    return "other sites may not change anything here";
  }
  return std::nullopt;
}

}  // namespace photond

#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/api/schema.h"
#include "server/store/keys.h"

namespace photond {

enum class ParameterIn { path, query, header };

struct Parameter {
  std::string name;
  ParameterIn place = ParameterIn::query;
  bool required = false;
  const Schema* schema = nullptr;
};

/// What may come back with one status.
struct Answer {
  std::map<std::string, const Schema*> content;    ///< by media type; empty: no body
  std::map<std::string, const Schema*> headers;    ///< by name
};

/// One method of one path.
struct Operation {
  std::string id;
  std::string method;   ///< "GET"
  std::string pattern;  ///< as in the table of routes
  std::optional<Scope> scope;  ///< of the keys that may do it; nothing: it needs none
  std::vector<Parameter> parameters;
  std::map<std::string, const Schema*> body;  ///< by media type; empty: it takes none
  std::map<std::string, Answer> answers;      ///< by status, or "default"
};

/// openapi.json, ready to be applied: what it says is what requests are checked against.
class Contract {
 public:
  /// Errors: invalid_input with the place in the document of whatever is not understood, so that nothing it says goes
  /// unheeded.
  static Result<Contract> read(std::string_view text);

  const std::vector<Operation>& operations() const { return operations_; }
  /// Null where there is none.
  const Operation* find(std::string_view method, std::string_view pattern) const;
  const Json& document() const { return *document_; }

 private:
  std::unique_ptr<const Json> document_;
  std::unique_ptr<Schemas> schemas_;
  std::vector<Operation> operations_;
};

}  // namespace photond

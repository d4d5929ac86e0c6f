#include "server/api/contract.h"

#include <algorithm>
#include <initializer_list>

namespace photond {

namespace {

std::string upper(const std::string& text) {
  std::string result = text;
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::toupper(c); });
  return result;
}

/// Walks the document; the first mistake stays, and what comes after it does not matter.
class ContractReader {
 public:
  ContractReader(const Json& document, Schemas& schemas) : document_(document), schemas_(schemas) {}

  Result<std::vector<Operation>> operations() {
    only(document_, "", {"openapi", "info", "servers", "paths", "components", "security", "tags"});
    for (const auto& [pattern, item] : member(document_, "", "paths").items()) {
      const std::string where = "/paths/" + pointer_token(pattern);
      only(item, where, {"parameters", "get", "post", "delete"});
      for (const auto& [method, source] : item.items()) {
        if (method == "parameters") continue;
        Operation& operation = operations_.emplace_back();
        operation.method = upper(method);
        operation.pattern = pattern;
        if (item.contains("parameters")) parameters(item["parameters"], where + "/parameters", operation);
        read(source, where + "/" + method, operation);
      }
    }
    check_links();
    if (error_) return *error_;
    return std::move(operations_);
  }

 private:
  void fail(const std::string& what, const std::string& where) {
    if (!error_) error_ = invalid_input(what, where);
  }

  void only(const Json& object, const std::string& where, std::initializer_list<std::string_view> names) {
    if (!object.is_object()) return fail("must be an object", where);
    for (const auto& [name, value] : object.items()) {
      if (std::find(names.begin(), names.end(), name) == names.end()) fail(name + " is not understood", where);
    }
  }

  const Json& member(const Json& object, const std::string& where, const std::string& name) {
    static const Json kNothing = Json::object();
    if (object.is_object() && object.contains(name)) return object[name];
    fail(name + " is missing", where);
    return kNothing;
  }

  std::string text(const Json& object, const std::string& where, const std::string& name) {
    const Json& value = member(object, where, name);
    if (value.is_string()) return value.get<std::string>();
    fail(name + " must be a string", where);
    return {};
  }

  const Schema* schema(const std::string& pointer) {
    const Result<const Schema*> schema = schemas_.at(pointer);
    if (schema) return *schema;
    if (!error_) error_ = schema.error();
    return nullptr;
  }

  /// What `object` refers to, if it does, and else itself.
  const Json& resolved(const Json& object, std::string& where) {
    if (!object.is_object() || !object.contains("$ref")) return object;
    const std::string target = text(object, where, "$ref");
    const Json* found = target.starts_with("#/") ? find_pointer(document_, target.substr(1)) : nullptr;
    if (found == nullptr) {
      fail("$ref leads nowhere", where);
      return object;
    }
    where = target.substr(1);
    return *found;
  }

  void read(const Json& source, const std::string& where, Operation& operation) {
    only(source, where,
         {"operationId", "summary", "description", "tags", "parameters", "requestBody", "responses", "security"});
    operation.id = text(source, where, "operationId");
    operation.scope = scope(source, where);
    if (source.contains("parameters")) parameters(source["parameters"], where + "/parameters", operation);
    if (source.contains("requestBody")) body(source["requestBody"], where + "/requestBody", operation);
    for (const auto& [status, response] : member(source, where, "responses").items())
      operation.answers.emplace(status, answer(response, where + "/responses/" + status));
  }

  /// `security` is [] where no key is needed, or [{"key": ["read"]}].
  std::optional<Scope> scope(const Json& operation, const std::string& where) {
    const bool own = operation.contains("security");
    const Json& security = own ? operation["security"] : member(document_, "", "security");
    if (security == Json::array()) return std::nullopt;
    const Json* name = find_pointer(security, "/0/key/0");
    const auto scope = name != nullptr && name->is_string() ? scope_from_name(name->get<std::string>()) : std::nullopt;
    if (!scope || security.size() != 1) fail("security must name one scope of a key", where);
    return scope;
  }

  void parameters(const Json& list, const std::string& where, Operation& operation) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      std::string at = where + "/" + std::to_string(i);
      const Json& source = resolved(list[i], at);
      only(source, at, {"name", "in", "description", "required", "schema", "explode"});
      Parameter parameter;
      parameter.name = text(source, at, "name");
      const std::string place = text(source, at, "in");
      if (place == "path") parameter.place = ParameterIn::path;
      else if (place == "header") parameter.place = ParameterIn::header;
      else if (place != "query") fail("in must be path, query or header", at);
      parameter.required = source.contains("required") && source["required"] == true;
      parameter.schema = schema(at + "/schema");
      operation.parameters.push_back(std::move(parameter));
    }
  }

  void body(const Json& source, const std::string& where, Operation& operation) {
    only(source, where, {"required", "description", "content"});
    if (!source.contains("required") || source["required"] != true) fail("a body must be required", where);
    operation.body = content(member(source, where, "content"), where + "/content");
  }

  std::map<std::string, const Schema*> content(const Json& source, const std::string& where) {
    std::map<std::string, const Schema*> types;
    for (const auto& [type, media] : source.items()) {
      const std::string at = where + "/" + pointer_token(type);
      only(media, at, {"schema", "example", "examples"});
      types.emplace(type, schema(at + "/schema"));
    }
    return types;
  }

  Answer answer(const Json& reference, std::string where) {
    const Json& source = resolved(reference, where);
    only(source, where, {"description", "content", "headers", "links"});
    Answer answer;
    if (source.contains("content")) answer.content = content(source["content"], where + "/content");
    if (source.contains("links")) links(source["links"], where + "/links");
    if (!source.contains("headers")) return answer;
    for (const auto& [name, entry] : source["headers"].items()) {
      std::string at = where + "/headers/" + name;
      const Json& header = resolved(entry, at);
      only(header, at, {"description", "required", "schema"});
      answer.headers.emplace(name, schema(at + "/schema"));
    }
    return answer;
  }

  void links(const Json& source, const std::string& where) {
    for (const auto& [name, link] : source.items()) {
      only(link, where + "/" + name, {"operationId", "parameters", "description"});
      linked_.emplace_back(text(link, where + "/" + name, "operationId"), &link);
    }
  }

  /// Links lead to operations that are there, and set parameters that these have.
  void check_links() {
    for (const auto& [id, link] : linked_) {
      const auto operation = std::find_if(operations_.begin(), operations_.end(),
                                          [&id = id](const Operation& candidate) { return candidate.id == id; });
      if (operation == operations_.end()) return fail("a link leads to " + id + ", which is not there", "");
      for (const auto& [name, value] : member(*link, "", "parameters").items()) {
        const bool known = std::any_of(operation->parameters.begin(), operation->parameters.end(),
                                       [&name = name](const Parameter& parameter) { return parameter.name == name; });
        if (!known) fail("a link sets " + name + ", which " + id + " does not have", "");
      }
    }
  }

  const Json& document_;
  Schemas& schemas_;
  std::vector<Operation> operations_;
  std::vector<std::pair<std::string, const Json*>> linked_;  ///< operationId, link
  std::optional<Error> error_;
};

}  // namespace

Result<Contract> Contract::read(std::string_view text) {
  Contract contract;
  auto document = Json::parse(text.begin(), text.end(), nullptr, false);
  if (document.is_discarded()) return invalid_input("the contract is not JSON");
  contract.document_ = std::make_unique<const Json>(std::move(document));
  contract.schemas_ = std::make_unique<Schemas>(*contract.document_);
  auto operations = ContractReader(*contract.document_, *contract.schemas_).operations();
  if (!operations) return operations.error();
  contract.operations_ = std::move(*operations);
  return contract;
}

const Operation* Contract::find(std::string_view method, std::string_view pattern) const {
  const auto found = std::find_if(operations_.begin(), operations_.end(), [&](const Operation& operation) {
    return operation.method == method && operation.pattern == pattern;
  });
  return found == operations_.end() ? nullptr : &*found;
}

}  // namespace photond

// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/names.h"

#include <nlohmann/json.hpp>

#include "io/text.h"

namespace eikon {

void make_names_printable(Json& value) {
  if (value.is_array()) {
    if (value.empty() || value[0].is_number()) return;  // long lists of numbers have no names
    for (Json& element : value) make_names_printable(element);
  }
  if (!value.is_object()) return;
  for (auto& [key, member] : value.items())
    if (key == "name" && member.is_string())
      member = printable(member.get_ref<const std::string&>());
    else if (member.is_structured())
      make_names_printable(member);
}

}  // namespace eikon

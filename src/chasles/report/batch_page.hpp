#pragma once

#include <span>
#include <string>

#include <nlohmann/json.hpp>

namespace chasles {

/// A recording of a batch for the page: its record (docs/many.md) and a JPEG; empty: none.
struct BatchRow {
  nlohmann::ordered_json record;
  std::string jpeg;
};

/// One self-contained HTML page that loads nothing: the verdicts of a batch, the worst first, with
/// reasons, figures, the path from above and a picture, as far as pictures fit into kPagePictures.
/// `summary`: content of the batch's summary.json; `difference`: to an earlier batch, or null. The
/// same arguments give the same bytes. Names are shown as text, whatever they contain.
std::string batch_page(const nlohmann::ordered_json& summary, std::span<const BatchRow> rows,
                       const nlohmann::ordered_json& difference);

}  // namespace chasles

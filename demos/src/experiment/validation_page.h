/// The document of a validation: generated parts between markers in a page whose prose is written
/// by hand, and a picture for each experiment.
#pragma once

#include <string>
#include <vector>

#include "comparison.h"

namespace bsoil::experiment {

/// Puts what was generated into the page, between
/// `<!-- bsoil validate: NAME -->` and `<!-- end -->`: a section for each comparison, and the table
/// of all under the name "summary", where the rows of experiments that were not run stay as they
/// are. "signs" lists forces with the wrong direction, "pooled" errors over all experiments of a
/// kind; a page may lack both. Sentences that name a figure of a table get it (fill_figures).
/// `pictures` is the folder of the pictures as the page names it. The error says which marker the
/// page lacks.
Result<std::string> update_page(std::string page, const std::vector<Comparison>& comparisons,
                                const std::string& pictures);

/// The plots of an experiment: measured, computed and classical.
std::string comparison_picture(const Comparison& comparison);

}  // namespace bsoil::experiment

#pragma once
// What is exported: the mechanism of a job, its loads, and the equilibrium in which it stands.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "optim/job/job.hpp"
#include "results/export/parts.hpp"

namespace flexopt {

/// The design of a job that is exported, and its stroke.
struct ExportPlace {
  /// Texts of --at: one quantity for the only drive ("20 deg"), or "name=quantity" for each named
  /// one (those that are not named stay at rest). None: undeflected and unloaded, as drawn.
  std::vector<std::string> at;
  std::string load_case;  ///< load case of a job with several; empty: the first
};

struct Exported {
  std::string name;       ///< name of the job
  Mechanism mechanism;    ///< as designed: nothing warm
  StrokeRequest request;  ///< request of its load case
  ModelOptions model;
  bool undeflected = true;
  /// Stroke of each drive [m or rad], or the factor of the growing loads; zeros where undeflected.
  VectorXd strokes;

  /// Equilibria of this mechanism at other strokes; `outputs` in addition to equilibria and shapes.
  /// Throws NoEquilibrium.
  std::vector<PathPoint> equilibria(const std::vector<VectorXd>& at, const ModelOptions& by,
                                    const Outputs& outputs = {}) const;
  std::vector<PathPoint> equilibria(const std::vector<VectorXd>& at) const {
    return equilibria(at, model);
  }
  /// The exported state. Undeflected: at rest without any load, where the same equations hold.
  PathPoint standing(const Outputs& outputs = {}) const;
  /// Strokes of the job's path, in its order.
  std::vector<VectorXd> path() const;
  /// The point of the path that is farthest from rest.
  VectorXd largest_strokes() const;
  /// Text of strokes: "uy = 0.02 m", "x = 0.001 m, y = 0 m".
  std::string stroke_text(const VectorXd& at) const;
};

/// Text of a name on one line, for use in comments of a file.
std::string one_line(std::string text);

/// Thrown where something could not be made that is to be exported: no fault of the input.
class NotExported : public std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Thrown where no equilibrium was found.
class NoEquilibrium : public NotExported {
  using NotExported::NotExported;
};

/// Throws SpecError for a stroke outside the job's path.
Exported make_exported(const Job& job, const ExportPlace& place);

// The formats that a mechanism is exported in, and their files.

/// A file before it is written.
struct ExportedFile {
  std::string name, content;
};

struct Making;  ///< what the files of a format are made of
struct ExportFormat {
  std::string name;     ///< name for --format
  std::string meaning;  ///< for the help
  std::vector<ExportedFile> (*make)(Making&);
};
const std::vector<ExportFormat>& export_formats();

/// Names in a list with commas. Throws SpecError for one that is unknown or there twice.
std::vector<std::string> read_formats(const std::string& list);

struct ExportOptions {
  std::vector<std::string> formats;
  std::string stem;         ///< how the files' names begin
  SolidMeshSize solid;      ///< size of the solids in decks
  bool monolithic = false;  ///< STEP: all in one solid
  double kerf = 0;          ///< DXF: width of the cut [m]; 0: the contour itself
};

struct WrittenExports {
  std::vector<std::string> names;  ///< names of the files
  std::vector<std::string> notes;  ///< what was left out of them, a sentence each
};

/// Writes the files of all formats, each whole or not at all, after all of them could be made.
/// Throws SpecError for what a format cannot carry, NotExported.
WrittenExports write_exports(const Exported& exported, const ExportOptions& options,
                             const std::filesystem::path& folder);

// The formats of export: from a mechanism, or from its parts, to the content of a file.

/// ASCII STL in millimetres, one closed solid a part, under its name.
std::string stl_text(const std::vector<TriangleMesh>& parts);

// Moving models for viewers and slides: glTF 2.0 in one binary file.

/// The content of a .glb file: leaves and bodies at `base` (null: undeflected), and an animation
/// through the points of the path and back, in which leaves and elastic bodies are morph targets
/// and bodies nodes that move. Metres.
std::string glb(const Mechanism& mechanism, const PathPoint* base,
                const std::vector<PathPoint>& path);

// Drawings for cutting, DXF R12 in millimetres.

/// The leaves laid flat, a closed outline of true size for each on a layer of its own, folds on the
/// layer FOLDS, beside them on TEXT their number, name and thickness; one outline for leaves that
/// are cut alike. Nothing where all leaves are wires.
std::optional<std::string> dxf_leaves(const Mechanism& mechanism);

struct DxfContour {
  std::optional<std::string> content;
  std::string reason;  ///< why there is no contour of the whole
};

/// Contour of a mechanism at a point of a path, or undeflected (null), seen along the width of its
/// leaves. Of one plate: leaves, bodies and ground as one closed outline on CONTOUR, its holes on
/// HOLES, on START a point outside and one in each hole where the wire begins. `kerf` [m]: width of
/// the cut; the outlines are then the path of the wire's centre. Where the whole has no one
/// contour: the section of each leaf on a layer of its own, and the reason. Nothing where the
/// leaves' widths lie along several directions.
DxfContour dxf_contour(const Exported& exported, const PathPoint* point, double kerf = 0);

// Solids for CAD, by Open CASCADE where the program was built with it.

struct StepFile {
  std::string content;
  std::vector<std::string> notes;  ///< what was left out, a sentence each
};

/// STEP (AP214) in millimetres at a point of a path or undeflected (null): a product with a name
/// and a colour for each leaf, each body and the ground, or one solid of all of them
/// (`monolithic`).
///
/// Undeflected leaves without profile are exact: prisms, arcs as splines through 121 places, wires
/// cylinders; flat ones have their fillets where the job gives a radius. Bent and profiled leaves
/// are splines through the points of their mesh. Reinforced leaves are one solid. Bodies and the
/// ground are those of body_forms; elastic bodies have flat faces between the nodes of their mesh.
/// Throws SpecError where the program was built without Open CASCADE, or where one solid of a
/// mechanism with joints, springs or elastic bodies is asked for; NotExported
/// where a solid could not be made, or a monolithic mechanism has no free place for a body.
StepFile step_file(const Exported& exported, const PathPoint* point, bool monolithic = false);

// Scripts for SPACAR Light (MATLAB): the mechanism in beams.

/// The script for these strokes: nodes, elements, nprops, eprops, opt, the call, and what flexopt
/// finds with beams at full accuracy in comments. Throws SpecError that names every item that
/// SPACAR Light cannot carry, NoEquilibrium.
std::string spacar_script(const Exported& exported, const VectorXd& strokes);

// Decks of CalculiX (its format is that of Abaqus): the mechanism in solid elements, driven to a
// stroke, and small loads there that tell its support stiffness.

/// The deck for these strokes, with the drive load, the motion of O and the support stiffness that
/// flexopt finds there at full accuracy in comments, which compare_ccx.py beside the deck reads.
/// Throws SpecError for what a deck cannot carry, NoEquilibrium.
std::string ccx_deck(const Exported& exported, const VectorXd& strokes, const SolidMeshSize& size);

}  // namespace flexopt

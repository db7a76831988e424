// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "step_file.h"

#include "base/regular_file.h"
#include "base/yaml_text.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepGProp.hxx>
#include <BRepTools.hxx>
#include <Bnd_Box.hxx>
#include <GCPnts_QuasiUniformDeflection.hxx>
#include <GProp_GProps.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <gp_Ax3.hxx>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr std::size_t kBytesMost = 200u << 20;  // more is an assembly
constexpr double kChordMm = 0.01;  // off a curve that is no arc, as the drawing's reader has it
constexpr double kFlatMm = 0.01;   // that a solid may rise above its largest face, by rounding
/// Areas that differ by less than this share are of one size.
constexpr double kSameArea = 1e-6;
/// Volume over face times thickness: 1 of a plate, less with chamfers, more with pockets in that
/// face, 0.1 of a bent sheet.
constexpr double kVolumeLeast = 0.5, kVolumeMost = 1.5;
constexpr double kFullTurn = 2.0 * M_PI, kDegree = M_PI / 180.0;

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

std::string mm(double value) { return yamlNumber(value, 3) + " mm"; }

/// All that is drawn.
class Dxf {
 public:
  void line(const gp_Pnt& a, const gp_Pnt& b) {
    entity("LINE");
    point(10, a);
    point(11, b);
  }
  void circle(const gp_Pnt& center, double radius) {
    entity("CIRCLE");
    point(10, center);
    group(40, radius);
  }
  /// Counter-clockwise, degrees.
  void arc(const gp_Pnt& center, double radius, double from, double to) {
    entity("ARC");
    point(10, center);
    group(40, radius);
    group(50, from);
    group(51, to);
  }
  std::string text() const {
    return "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" +
           entities_ + "0\nENDSEC\n0\nEOF\n";
  }

 private:
  void entity(const char* kind) { entities_ += std::string("0\n") + kind + "\n8\nOUTLINE\n"; }
  void group(int code, double value) {
    entities_ += std::to_string(code) + "\n" + yamlNumber(value, 9) + "\n";
  }
  void point(int code, const gp_Pnt& p) {
    group(code, p.X());
    group(code + 10, p.Y());
  }
  std::string entities_;
};

TopoDS_Shape readShape(const std::string& path) {
  const std::string text = readRegularFile(path, kBytesMost);
  if (text.find("ISO-10303-21") == std::string::npos)
    refuse(path, "is no STEP file, ISO-10303-21 does not stand in it; export it anew");
  // Its library writes to stdout, which is for what was read.
  Message::DefaultMessenger()->ChangePrinters().Clear();
  STEPControl_Reader reader;
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  const std::string damaged = "is a damaged STEP file, or holds no shape; export it anew";
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) refuse(path, damaged);
  if (reader.TransferRoots() == 0) refuse(path, damaged);
  return reader.OneShape();
}

TopoDS_Shape onlySolid(const TopoDS_Shape& shape, const std::string& path) {
  int count = 0;
  TopoDS_Shape solid;
  for (TopExp_Explorer it(shape, TopAbs_SOLID); it.More(); it.Next(), ++count) solid = it.Current();
  if (count == 0) refuse(path, "has no solid in it, such as a surface alone; export the solid");
  if (count > 1)
    refuse(path, "has " + std::to_string(count) + " solids; export one part without the others");
  return solid;
}

struct FlatFace {
  TopoDS_Face face;
  double area = 0.0;
  gp_Dir normal;  ///< out of the solid
};

/// Whether a looks up more than b: by z, then y, then x.
bool looksUp(const gp_Dir& a, const gp_Dir& b) {
  constexpr double kSame = 1e-6;
  if (std::abs(a.Z() - b.Z()) > kSame) return a.Z() > b.Z();
  if (std::abs(a.Y() - b.Y()) > kSame) return a.Y() > b.Y();
  return a.X() > b.X();
}

FlatFace largestFlat(const TopoDS_Shape& solid, const std::string& path) {
  FlatFace best;
  for (TopExp_Explorer it(solid, TopAbs_FACE); it.More(); it.Next()) {
    const TopoDS_Face face = TopoDS::Face(it.Current());
    const BRepAdaptor_Surface surface(face);
    if (surface.GetType() != GeomAbs_Plane) continue;
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(face, properties);
    const gp_Pln plane = surface.Plane();
    gp_Dir normal = plane.Axis().Direction();
    if (plane.Direct() == (face.Orientation() == TopAbs_REVERSED)) normal.Reverse();
    const double area = properties.Mass(), slack = kSameArea * best.area;
    const bool same = std::abs(area - best.area) <= slack;
    if (area > best.area + slack || (same && looksUp(normal, best.normal)))
      best = {face, area, normal};
  }
  if (best.area <= 0.0) refuse(path, "has no flat face; is it a flat part?");
  return best;
}

/// From the file's frame to the part's.
gp_Trsf partFrame(const FlatFace& flat) {
  const gp_Dir z = flat.normal;
  constexpr double kAlong = 0.9;  // of x to the normal: then y takes its place
  const gp_Dir along = std::abs(z.X()) < kAlong ? gp::DX() : gp::DY();
  const gp_Pnt on_face = BRepAdaptor_Surface(flat.face).Plane().Location();
  const gp_Pnt origin(gp_Vec(z).Multiplied(gp_Vec(gp::Origin(), on_face).Dot(gp_Vec(z))).XYZ());
  gp_Trsf T_part_file;
  T_part_file.SetTransformation(gp_Ax3(origin, z, along));  // its x is `along` within the face
  return T_part_file;
}

double angleOf(const gp_Pnt& p, const gp_Pnt& center) {
  const double angle = std::atan2(p.Y() - center.Y(), p.X() - center.X());
  return (angle < 0.0 ? angle + kFullTurn : angle) / kDegree;
}

void draw(const TopoDS_Edge& edge, const std::string& path, Dxf* dxf) {
  const BRepAdaptor_Curve curve(edge);
  const double first = curve.FirstParameter(), last = curve.LastParameter();
  const gp_Pnt a = curve.Value(first), b = curve.Value(last);
  if (curve.GetType() == GeomAbs_Line) return dxf->line(a, b);
  if (curve.GetType() == GeomAbs_Circle) {
    const gp_Circ circle = curve.Circle();
    const gp_Pnt center = circle.Location();
    constexpr double kClosed = 1e-9;
    if (last - first > kFullTurn - kClosed) return dxf->circle(center, circle.Radius());
    const bool counter_clockwise = circle.Axis().Direction().Z() > 0.0;
    return dxf->arc(center, circle.Radius(), angleOf(counter_clockwise ? a : b, center),
                    angleOf(counter_clockwise ? b : a, center));
  }
  const GCPnts_QuasiUniformDeflection chords(curve, kChordMm);
  if (!chords.IsDone() || chords.NbPoints() < 2) refuse(path, "has a contour that cannot be drawn");
  for (int i = 1; i < chords.NbPoints(); ++i) dxf->line(chords.Value(i), chords.Value(i + 1));
}

StepPart flatten(const std::string& path) {
  const TopoDS_Shape solid = onlySolid(readShape(path), path);
  const FlatFace flat = largestFlat(solid, path);
  const gp_Trsf T_part_file = partFrame(flat);
  Bnd_Box box;
  BRepBndLib::AddOptimal(BRepBuilderAPI_Transform(solid, T_part_file).Shape(), box,
                         /*useTriangulation=*/false, /*useShapeTolerance=*/false);
  const double above = box.CornerMax().Z(), thickness = -box.CornerMin().Z();
  if (above > kFlatMm) {
    refuse(path, "is no flat part: it rises " + mm(above) +
                     " above its largest flat face; draw its contour as DXF");
  }
  GProp_GProps properties;
  BRepGProp::VolumeProperties(solid, properties);
  const double share = std::abs(properties.Mass()) / (flat.area * thickness);
  if (!(share > kVolumeLeast && share < kVolumeMost)) {
    refuse(path, "is no flat part: it fills " + yamlNumber(100.0 * share, 0) +
                     " % of its largest flat face times its height of " + mm(thickness) +
                     "; draw its contour as DXF");
  }
  Dxf dxf;
  const TopoDS_Shape face = BRepBuilderAPI_Transform(flat.face, T_part_file).Shape();
  for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next())
    draw(TopoDS::Edge(it.Current()), path, &dxf);
  return {dxf.text(), thickness};
}

}  // namespace

StepPart readStep(const std::string& path) {
  try {
    return flatten(path);
  } catch (const Standard_Failure& failure) {
    const char* what = failure.GetMessageString();
    refuse(path, "cannot be read as STEP (" + std::string(what == nullptr ? "" : what) +
                     "); export it anew");
  }
}

}  // namespace planar_bin_picking

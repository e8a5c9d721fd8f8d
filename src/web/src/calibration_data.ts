// What the page of a calibration is about: the content of cameras.json, and the corners.
import { type Columns, decodeColumns } from './data';

export interface Parameter {
  name: string;
  value: number;
  unit: string;
  sigma: number;
  halves_difference?: number;
  halves_sigma?: number;
}

interface LensTrial { lens: string; held_out_rms_px: number | null; fault: string }

export interface CalibratedCamera {
  lens: string;
  resolution: [number, number];
  cam_T_cam0: number[][];
  views: number;
  corners: number;
  rms_px: number;
  rms_before_px: number | null;
  /** Rows of u, v, sigma [px], sigma [rad]. */
  projection: { grid: [number, number, number, number][] };
  halves_px?: number;
  halves_sigma_px?: number;
  lenses?: LensTrial[];
}

export interface CamerasJson {
  pixel_sigma_px: number;
  correlation_factor: number;
  views: number;
  views_without_pose: number;
  held_out_rms_px?: number;
  cameras: CalibratedCamera[];
  parameters: Parameter[];
  covariance: number[][];
  suspicious: string[];
  missing: string[];
  remarks: string[];
}

type Packed = Record<string, string>;

export interface CamerasData {
  kind: 'cameras';
  calibration: CamerasJson;
  cameras: { cells: { columns: number; rows: number; figures: Packed }; corners: Packed }[];
  views: { first_s: number; figures: Packed };
}

/** Parts of an image, row by row: corners, du, dv [px]. */
export interface Cells { columns: number; rows: number; figures: Columns }

export interface CameraFigures {
  name: string;
  camera: CalibratedCamera;
  cells: Cells;
  /** u, v, du, dv [px] of some of the corners. */
  corners: Columns;
}

export const figuresOf = ({ calibration, cameras }: CamerasData): CameraFigures[] =>
  cameras.map(({ cells, corners }, c) => ({
    name: `cam${c}`,
    camera: calibration.cameras[c],
    cells: { ...cells, figures: decodeColumns(cells.figures) },
    corners: decodeColumns(corners),
  }));

// What the page of a batch is about: the records of verdicts.jsonl, with a sketch and a picture.

export type Verdict = 'no' | 'check' | 'use';
export const VERDICTS: readonly Verdict[] = ['no', 'check', 'use'];

export interface Recording {
  name: string;
  recording: string;
  verdict: Verdict;
  reasons: { reason: string; what: string }[];
  coverage?: number | null;
  recorded_seconds?: number | null;
  length_m?: number;
  worst_sigma_m?: number;
  drift_m_per_100m?: number;
  ate_posyaw_m?: number | null;
  sketch?: { x: number[]; y: number[] } | null;
  picture?: string;
}

export interface Ratio { pairs: number; ratio: number; low: number | null; high: number | null }
interface Change { name: string; before: Verdict; now: Verdict }

export interface Difference {
  better: Change[];
  worse: Change[];
  only_before: string[];
  only_now: string[];
  figures: Record<string, Ratio>;
}

export interface Batch {
  summary: {
    recordings: number;
    verdicts: Record<Verdict, number>;
    reasons: Record<string, number>;
    recorded_seconds: number;
    length_m: number;
    plan: Record<string, unknown>;
  };
  recordings: Recording[];
  difference: Difference | null;
}

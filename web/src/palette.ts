// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

/** Colours of Okabe and Ito in the order of the pictures, darker on white; shapes tell them again. */
const kLight = ['#b8860b', '#009e73', '#cc79a7', '#2f8fc4', '#882255', '#8a8a2e', '#d55e00', '#555555'];
const kDark = ['#f0c24b', '#2fd6a4', '#e7a3cb', '#8fd0ff', '#e08ab8', '#d8d86a', '#ff8a3d', '#bbbbbb'];

export type Shape = 'circle' | 'square' | 'triangle' | 'diamond' | 'cross' | 'star' | 'wedge' | 'bar';
const kShapes: Shape[] = ['circle', 'square', 'triangle', 'diamond', 'cross', 'star', 'wedge', 'bar'];

export const isDark = () => document.documentElement.dataset.theme === 'dark';

export function classColor(index: number | null): string {
  const colors = isDark() ? kDark : kLight;
  return index === null ? (isDark() ? '#c9d1d9' : '#3b4650') : colors[index % colors.length];
}

/** Of the path of a robot, as in the pictures: that of a single one is the first. */
export function robotColor(index: number): string {
  const colors = [themed('estimate'), ...[0, 2, 3, 4, 5].map(classColor)];
  return colors[index % colors.length];
}

export function classShape(index: number | null): Shape {
  return index === null ? 'circle' : kShapes[index % kShapes.length];
}

/** The colour of a decision about a closure, in the style sheet: one of three, whatever the method calls it. */
export const decisionColor = (decision: string) => decision.startsWith('reject') || decision === 'outlier' ? 'rejected'
    : decision === 'undecided' ? 'undecided' : 'accepted';

/** A colour of the style sheet. */
export function themed(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Adds a mark of radius r about a point to the path. */
export function trace(c: CanvasRenderingContext2D, shape: Shape, x: number, y: number, r: number) {
  const polygon = (...points: [number, number][]) => {
    points.forEach(([dx, dy], i) => i ? c.lineTo(x + r * dx, y + r * dy) : c.moveTo(x + r * dx, y + r * dy));
    c.closePath();
  };
  switch (shape) {
    case 'circle': c.moveTo(x + r, y); c.arc(x, y, r, 0, 2 * Math.PI); break;
    case 'square': c.rect(x - 0.88 * r, y - 0.88 * r, 1.76 * r, 1.76 * r); break;
    case 'triangle': polygon([0, -1.15], [1, 0.75], [-1, 0.75]); break;
    case 'wedge': polygon([0, 1.15], [1, -0.75], [-1, -0.75]); break;
    case 'diamond': polygon([0, -1.2], [1.1, 0], [0, 1.2], [-1.1, 0]); break;
    case 'bar': c.rect(x - r, y - 0.5 * r, 2 * r, r); break;
    case 'cross': {
      const a = 0.4, b = 1.1;
      polygon([-a, -b], [a, -b], [a, -a], [b, -a], [b, a], [a, a], [a, b], [-a, b], [-a, a], [-b, a], [-b, -a], [-a, -a]);
      break;
    }
    case 'star': {
      const points: [number, number][] = [];
      for (let i = 0; i < 10; ++i) {
        const radius = i % 2 ? 0.5 : 1.25, angle = -Math.PI / 2 + (i * Math.PI) / 5;
        points.push([radius * Math.cos(angle), radius * Math.sin(angle)]);
      }
      polygon(...points);
    }
  }
}

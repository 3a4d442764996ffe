// The points of a transfer function and their edits, without an interface.
using System;
using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using UnityEngine;

namespace Lumivox.Tests
{
    public sealed class EditorTransferFunctionModelTests
    {
        static TransferFunctionModel Model(params (double value, double opacity)[] knots) => new TransferFunctionModel
        {
            State = new TransferFunctionState(knots.Select(knot => new OpacityPoint(knot.value, knot.opacity)), new[] { new ColorPoint(0, Color.black), new ColorPoint(100, Color.white) }),
        };

        static void Near(double expected, double actual, double within = 1e-6) => Assert.That(actual, Is.EqualTo(expected).Within(within));

        [Test]
        public void EndsHoldAndEqualValuesJump()
        {
            var model = Model((0, 0.2), (100, 0.4), (100, 0.9), (200, 1));
            Near(0.2, model.OpacityAt(-1e9));
            Near(0.3, model.OpacityAt(50));
            Assert.That(model.OpacityAt(99.999), Is.LessThan(0.41));
            Near(0.9, model.OpacityAt(100));
            Near(1, model.OpacityAt(1e9));
        }

        [Test]
        public void EaseIsSlowAtBothEnds()
        {
            var model = Model((0, 0), (1, 1));
            model.SetEase(0, true);
            Near(0.5, model.OpacityAt(0.5));
            Near(0.01 / 0.82, model.OpacityAt(0.1));
            Near(0.81 / 0.82, model.OpacityAt(0.9));
        }

        [Test]
        public void LightIsMixedLinearly()
        {
            var middle = Model((0, 1)).ColorAt(50);
            // Half the light of white is brighter than half its code.
            Near(0.7354, middle.r, 0.002);
            Near(middle.r, middle.b);
            Near(1, middle.a);
        }

        [Test]
        public void WithoutColoursItIsWhiteAndWithoutKnotsNothingIsSeen()
        {
            var model = new TransferFunctionModel();
            Assert.That(model.IsEmpty);
            Near(0, model.OpacityAt(0));
            Assert.That(model.ColorAt(0), Is.EqualTo(Color.white));
            Assert.That(model.StoredRange, Is.EqualTo((0.0, 1.0)));
            // The first knot brings a colour with it.
            model.AddKnot(300, 0.5);
            Assert.That(model.Stops.Count, Is.EqualTo(1));
        }

        [Test]
        public void WhatIsNotFiniteIsPassedOverAndPointsAreSorted()
        {
            var state = new TransferFunctionState(
                new[] { new OpacityPoint(2, 3), new OpacityPoint(double.NaN, 1), new OpacityPoint(1, -1), new OpacityPoint(0, double.PositiveInfinity) },
                new[] { new ColorPoint(5, Color.red), new ColorPoint(double.NegativeInfinity, Color.red), new ColorPoint(4, Color.green) }, double.NaN, 1e9);
            Assert.That(state.Knots.Select(knot => (knot.value, knot.opacity)), Is.EqualTo(new[] { (1.0, 0.0), (2.0, 1.0) }));
            Assert.That(state.Stops.Select(stop => stop.value), Is.EqualTo(new[] { 4.0, 5.0 }));
            Near(0, state.Shift);
            Near(100, state.WindowScale);
        }

        [Test]
        public void BakingTheWindowChangesNothingThatIsSeen()
        {
            var random = new System.Random(3);
            for (var round = 0; round < 50; round++)
            {
                var model = Model(Enumerable.Range(0, 5).Select(_ => (random.NextDouble() * 2000 - 1000, random.NextDouble())).ToArray());
                model.SetWindow(random.NextDouble() * 500, 50 + random.NextDouble() * 3000);
                var values = Enumerable.Range(0, 40).Select(_ => random.NextDouble() * 4000 - 2000).ToArray();
                var before = values.Select(value => (model.OpacityAt(value), model.ColorAt(value).g)).ToArray();
                model.BakeWindow();
                Near(0, model.Shift);
                Near(1, model.WindowScale);
                for (var i = 0; i < values.Length; i++)
                {
                    Near(before[i].Item1, model.OpacityAt(values[i]), 1e-6);
                    Near(before[i].g, model.ColorAt(values[i]).g, 1e-4);
                }
            }
        }

        [Test]
        public void TheWindowPutsThePointsWhereItIsAsked()
        {
            var model = Model((0, 0), (200, 1));
            model.SetWindow(400, 100);
            Assert.That(model.ShownRange, Is.EqualTo((350.0, 450.0)));
            Near(0.5, model.OpacityAt(400));
            model.SetWindow(double.NaN, 10);
            Assert.That(model.ShownRange, Is.EqualTo((350.0, 450.0)));
            // Not narrower than a hundredth.
            model.SetWindow(0, 0);
            Near(0.01, model.WindowScale);
            model.ResetWindow();
            Assert.That(model.ShownRange, Is.EqualTo((0.0, 200.0)));
        }

        [Test]
        public void KnotsStayBetweenTheirNeighbours()
        {
            var model = Model((0, 0), (100, 0.5), (200, 1));
            model.MoveKnot(1, 500, 2);
            Assert.That(model.Knots[1].value, Is.LessThan(200).And.GreaterThan(199.9));
            Near(1, model.Knots[1].opacity);
            model.MoveKnot(1, -500, -1);
            Assert.That(model.Knots[1].value, Is.GreaterThan(0).And.LessThan(0.1));
            Near(0, model.Knots[1].opacity);
            model.MoveKnot(1, double.NaN, 0.5);
            Near(0, model.Knots[1].opacity);
        }

        [Test]
        public void AKnotThatIsAddedTakesOverTheEaseOfItsSegment()
        {
            var model = Model((0, 0), (100, 1), (200, 0));
            model.SetEase(0, true);
            Assert.That(model.AddKnot(50, 0.5), Is.EqualTo(1));
            Assert.That(model.Knots.Select(knot => knot.eases), Is.EqualTo(new[] { true, true, false, false }));
            Assert.That(model.AddKnot(-10, 0.1), Is.EqualTo(0));
            Assert.That(model.SegmentAt(60), Is.EqualTo(2));
            Assert.That(model.SegmentAt(201), Is.EqualTo(-1));
        }

        [Test]
        public void PointsAreEditedAsTheyAreSeen()
        {
            var model = Model((0, 0), (100, 1));
            model.SetWindow(1050, 100);
            var added = model.AddKnot(1050, 0.25);
            Near(1050, model.Knots[added].value);
            Near(0, model.Shift);
            model.SetWindow(2000, 200);
            var stop = model.AddStop(2000, Color.red);
            Near(2000, model.Stops[stop].value);
            Near(2000, model.Shown(model.Knots[added].value), 1e-9);
        }

        [Test]
        public void TheLastPointStays()
        {
            var model = Model((0, 0), (100, 1));
            Assert.That(model.RemoveKnot(0));
            Assert.That(model.RemoveKnot(0), Is.False);
            Assert.That(model.RemoveStop(1));
            Assert.That(model.RemoveStop(0), Is.False);
        }

        [Test]
        public void StatesAreEqualByWhatTheyHold()
        {
            var model = Model((0, 0), (100, 1));
            var before = model.State;
            Assert.That(model.State, Is.EqualTo(before));
            model.SetColor(0, Color.red);
            Assert.That(model.State, Is.Not.EqualTo(before));
            model.State = before;
            Assert.That(model.State, Is.EqualTo(before));
            model.SetEaseEverywhere(true);
            Assert.That(model.State, Is.Not.EqualTo(before));
        }

        [Test]
        public void HistoryGoesBackAndForthAndJoinsSeries()
        {
            var model = Model((0, 0), (100, 1));
            var history = new TransferFunctionHistory();
            var states = new List<TransferFunctionState> { model.State };
            void Do(Action edit, string series)
            {
                var before = model.State;
                edit();
                history.Add(new TransferFunctionEdit("Edit", before, model.State, series));
                states.Add(model.State);
            }
            Do(() => model.AddKnot(50, 0.5), null);
            Do(() => model.MoveKnot(1, 51, 0.5), "keys 1");
            Do(() => model.MoveKnot(1, 52, 0.5), "keys 1");
            Assert.That(history.Count, Is.EqualTo(2));
            Assert.That(history.Undo(), Is.EqualTo(states[1]));
            Assert.That(history.Undo(), Is.EqualTo(states[0]));
            Assert.That(history.Undo(), Is.Null);
            Assert.That(history.Redo(), Is.EqualTo(states[1]));
            Assert.That(history.Redo(), Is.EqualTo(states[3]));
            Assert.That(history.CanRedo, Is.False);
            history.Undo();
            Do(() => model.SetEase(0, true), null);
            Assert.That(history.CanRedo, Is.False);
        }

        [Test]
        public void TheAxisZoomsPansAndKeepsItsLimits()
        {
            var axis = new ValueAxis();
            axis.SetFull(-1000, 3000);
            Assert.That(axis.View, Is.EqualTo((-1000.0, 3000.0)));
            axis.Zoom(4, 0);
            Near(1000, axis.Width);
            Near(0, axis.ValueAt(axis.PixelOf(0, 400, 14), 400, 14), 0.01);
            for (var i = 0; i < 100; i++) axis.Zoom(2, 0);
            Near(8, axis.Width, 0.001);
            axis.Pan(1e9);
            Assert.That(axis.View.low, Is.LessThan(3000));
            axis.ShowAll();
            axis.SetFull(0, 0);
            Assert.That(axis.View, Is.EqualTo((-0.5, 0.5)));
        }

        [Test]
        public void TicksAreRoundAndTextHasTheDecimalsThatTheViewNeeds()
        {
            var axis = new ValueAxis { Unit = "HU" };
            axis.SetFull(-1000, 3000);
            var ticks = new List<double>();
            axis.Ticks(5, ticks);
            Assert.That(ticks, Is.EqualTo(new[] { -1000.0, 0, 1000, 2000, 3000 }));
            Assert.That(axis.Text(-12.345), Is.EqualTo("\u221212 HU"));
            Assert.That(axis.Text(-0.001, false), Is.EqualTo("0"));
            axis.Show(0, 1);
            axis.Show(0, 8);
            Assert.That(axis.Text(1.25, false), Is.EqualTo("1.25").Or.EqualTo("1.2"));
        }

        /// The model draws what the library traces.
        [Test]
        public void TheModelIsTheLibrarysFunction()
        {
            var random = new System.Random(11);
            for (var round = 0; round < 20; round++)
            {
                var function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
                var knots = Enumerable.Range(0, 6).Select(_ => new LumivoxTransferFunction.OpacityKnot(random.Next(-1000, 2000), (float)random.NextDouble(), (LumivoxTransferFunction.Ease)random.Next(2)));
                var stops = Enumerable.Range(0, 4).Select(_ => new LumivoxTransferFunction.ColorStop(random.Next(-1000, 2000), new Color((float)random.NextDouble(), (float)random.NextDouble(), (float)random.NextDouble(), 1)));
                function.SetPoints(knots.ToList(), stops.ToList());
                function.shift = random.Next(-300, 300);
                function.windowScale = (float)(0.3 + random.NextDouble() * 3);
                var model = new TransferFunctionModel { State = function.GetState() };
                var sampled = new Vector4[257];
                function.Sample(-2000, 3000, sampled);
                for (var i = 0; i < sampled.Length; i++)
                {
                    var value = -2000 + 5000.0 * i / (sampled.Length - 1);
                    Near(sampled[i].w, model.OpacityAt(value), 2e-5);
                    var light = model.ColorAt(value).linear;
                    Near(sampled[i].x, light.r, 2e-4);
                    Near(sampled[i].y, light.g, 2e-4);
                    Near(sampled[i].z, light.b, 2e-4);
                }
                UnityEngine.Object.DestroyImmediate(function);
            }
        }
    }
}

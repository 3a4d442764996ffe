// The transfer-function editor under a hand: pointer, wheel and keys, as a person uses them.
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Tests
{
    public sealed class EditorTransferFunctionFieldTests
    {
        LumivoxTransferFunction function;
        TransferFunctionField field;
        Panel panel;

        [SetUp]
        public void Open()
        {
            function = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            function.SetPoints(
                new[] { new LumivoxTransferFunction.OpacityKnot(0, 0), new LumivoxTransferFunction.OpacityKnot(100, 0.5f), new LumivoxTransferFunction.OpacityKnot(200, 1) },
                new[] { new LumivoxTransferFunction.ColorStop(0, Color.red), new LumivoxTransferFunction.ColorStop(200, Color.white) });
            field = new TransferFunctionField { transferFunction = function };
            var root = new VisualElement();
            root.Add(field);
            panel = new Panel(root, 640, 400);
        }

        [TearDown]
        public void Close()
        {
            field.RemoveFromHierarchy();
            Object.DestroyImmediate(function);
        }

        Vector2 Knot(int index) => field.Graph.worldBound.position + field.Graph.PlaceOf(index);
        Vector2 Stop(int index) => field.Colors.worldBound.position + new Vector2(field.Colors.PlaceOf(index), 24);
        Vector2 InGraph(double value, float y) => field.Graph.worldBound.position + new Vector2(field.Graph.PixelOf(value), y);
        static void Near(double expected, double actual, double within) => Assert.That(actual, Is.EqualTo(expected).Within(within));

        void Drag(Vector2 from, Vector2 to, EventModifiers modifiers = EventModifiers.None)
        {
            panel.PointerDown(from);
            for (var i = 1; i <= 4; i++) panel.PointerMove(Vector2.Lerp(from, to, i / 4f), modifiers);
            panel.PointerUp(to, modifiers: modifiers);
        }

        [Test]
        public void AKnotFollowsThePointerAndIsOneEdit()
        {
            int begun = 0, ended = 0, changes = 0;
            field.editStarted += _ => begun++;
            field.editFinished += _ => ended++;
            function.changed += () => changes++;
            Drag(Knot(1), Knot(1) + new Vector2(40, 30));
            Assert.That((begun, ended), Is.EqualTo((1, 1)));
            // The picture follows while it is dragged.
            Assert.That(changes, Is.GreaterThanOrEqualTo(4));
            Assert.That(function.opacityKnots[1].value, Is.GreaterThan(110));
            Assert.That(function.opacityKnots[1].opacity, Is.LessThan(0.45f));
            Assert.That(field.Graph.Selected, Is.EqualTo(1));
            Assert.That(field.History.Count, Is.EqualTo(1));
        }

        [Test]
        public void AClickMovesNothing()
        {
            var before = function.GetState();
            panel.Click(Knot(1) + new Vector2(4, 3));
            Assert.That(function.GetState(), Is.EqualTo(before));
            Assert.That(field.History.CanUndo, Is.False);
        }

        [Test]
        public void ShiftKeepsTheValueAndControlTheOpacity()
        {
            Drag(Knot(1), Knot(1) + new Vector2(40, 30), EventModifiers.Shift);
            Near(100, function.opacityKnots[1].value, 1e-4);
            Assert.That(function.opacityKnots[1].opacity, Is.LessThan(0.45f));
            var opacity = function.opacityKnots[1].opacity;
            var from = Knot(1);
            panel.PointerDown(from);
            panel.PointerMove(from + new Vector2(30, -20), EventModifiers.Control);
            panel.PointerUp(from + new Vector2(30, -20), modifiers: EventModifiers.Control);
            Near(opacity, function.opacityKnots[1].opacity, 1e-6);
            Assert.That(function.opacityKnots[1].value, Is.GreaterThan(105));
        }

        [Test]
        public void EscapeGivesADragUp()
        {
            var before = function.GetState();
            panel.PointerDown(Knot(1));
            panel.PointerMove(Knot(1) + new Vector2(60, 10));
            Assert.That(function.GetState(), Is.Not.EqualTo(before));
            panel.Key(KeyCode.Escape);
            Assert.That(function.GetState(), Is.EqualTo(before));
            panel.PointerMove(Knot(1) + new Vector2(90, 10));
            panel.PointerUp(Knot(1) + new Vector2(90, 10));
            Assert.That(function.GetState(), Is.EqualTo(before));
            Assert.That(field.History.CanUndo, Is.False);
        }

        [Test]
        public void LosingThePointerEndsADragWhereItIs()
        {
            panel.PointerDown(Knot(1));
            panel.PointerMove(Knot(1) + new Vector2(30, 0));
            var reached = function.GetState();
            panel.LoseCapture();
            panel.PointerMove(Knot(1) + new Vector2(90, 0));
            Assert.That(function.GetState(), Is.EqualTo(reached));
            Assert.That(field.History.Count, Is.EqualTo(1));
        }

        [Test]
        public void ADoubleClickAddsAKnotThatCanBeDraggedAtOnce()
        {
            var at = InGraph(50, 40);
            panel.PointerDown(at, clicks: 2);
            Assert.That(function.opacityKnots.Count, Is.EqualTo(4));
            panel.PointerMove(at + new Vector2(0, 20));
            panel.PointerUp(at + new Vector2(0, 20));
            Near(50, function.opacityKnots[1].value, 1);
            Assert.That(field.History.Count, Is.EqualTo(1));
            field.Focus();
            panel.Focus(field.Graph);
            panel.Key(KeyCode.Z, EventModifiers.Control);
            Assert.That(function.opacityKnots.Count, Is.EqualTo(3));
            panel.Key(KeyCode.Y, EventModifiers.Control);
            Assert.That(function.opacityKnots.Count, Is.EqualTo(4));
        }

        [Test]
        public void ARightClickRemovesAKnotAndDeleteTheOneThatIsChosen()
        {
            panel.Click(Knot(1), 1);
            Assert.That(function.opacityKnots.Count, Is.EqualTo(2));
            panel.Click(Knot(1));
            panel.Key(KeyCode.Delete);
            Assert.That(function.opacityKnots.Count, Is.EqualTo(1));
            panel.Click(Knot(0), 1);
            Assert.That(function.opacityKnots.Count, Is.EqualTo(1), "the last knot stays");
        }

        [Test]
        public void ARightClickOnTheCurveChangesItsEase()
        {
            panel.Click(InGraph(150, 30), 1);
            Assert.That(Menus.IsChecked("Straight segment"));
            Menus.Choose("Ease in and out");
            Assert.That(function.opacityKnots.Select(knot => knot.ease), Is.EqualTo(new[] { LumivoxTransferFunction.Ease.Linear, LumivoxTransferFunction.Ease.InOut, LumivoxTransferFunction.Ease.Linear }));
            panel.Click(InGraph(150, 30), 1);
            Menus.Choose("Straight everywhere");
            Assert.That(function.opacityKnots.All(knot => knot.ease == LumivoxTransferFunction.Ease.Linear));
            panel.Click(InGraph(210, 30), 1);
            Assert.That(Menus.IsEnabled("Ease in and out"), Is.False, "no segment is there");
            Menus.Choose("Add knot here");
            Assert.That(function.opacityKnots.Count, Is.EqualTo(4));
        }

        [Test]
        public void KeysMoveTheKnotAsOneStepAndKeepTheFocus()
        {
            panel.Click(Knot(1));
            for (var i = 0; i < 3; i++) Assert.That(panel.Key(KeyCode.RightArrow), Is.False, "the focus would go elsewhere");
            panel.Key(KeyCode.UpArrow, EventModifiers.Shift);
            Near(0.55, function.opacityKnots[1].opacity, 1e-5);
            Assert.That(function.opacityKnots[1].value, Is.GreaterThan(100));
            Assert.That(field.History.Count, Is.EqualTo(1));
            panel.Key(KeyCode.Z, EventModifiers.Control);
            Near(100, function.opacityKnots[1].value, 1e-4);
            panel.Key(KeyCode.Period);
            Assert.That(field.Graph.Selected, Is.EqualTo(2));
            panel.Key(KeyCode.Comma);
            panel.Key(KeyCode.E);
            Assert.That(function.opacityKnots[1].ease, Is.EqualTo(LumivoxTransferFunction.Ease.InOut));
            panel.Key(KeyCode.Escape);
            Assert.That(field.Graph.Selected, Is.EqualTo(-1));
        }

        [Test]
        public void TheWheelZoomsWhereThePointerIs()
        {
            var width = field.Axis.Width;
            var at = InGraph(100, 40);
            panel.Wheel(at, -3);
            Near(width / 1.2, field.Axis.Width, 1e-3);
            Near(at.x, InGraph(100, 40).x, 0.01);
            panel.Key(KeyCode.A);
            panel.PointerDown(at, 2);
            var low = field.Axis.View.low;
            panel.PointerMove(at + new Vector2(-30, 0));
            panel.PointerUp(at + new Vector2(-30, 0), 2);
            Assert.That(field.Axis.View.low, Is.GreaterThan(low));
        }

        [Test]
        public void TheWindowIsDraggedWidenedTypedAndReset()
        {
            Vector2 At(double value) => field.Window.worldBound.position + new Vector2(field.Window.PixelOf(value), 8);
            Drag(At(100), At(150));
            Near(50, function.shift, 2);
            Near(1, function.windowScale, 1e-4);
            field.ShowPoints();
            Drag(At(250), At(350));
            Assert.That(function.windowScale, Is.GreaterThan(1.3f));
            Near(50, field.Model.ShownRange.low, 2);
            field.Q<DoubleField>("level").value = 400;
            field.Q<DoubleField>("width").value = 100;
            Near(350, field.Model.ShownRange.low, 0.01);
            Near(450, field.Model.ShownRange.high, 0.01);
            field.Q<DoubleField>("width").value = -5;
            Near(100, field.Q<DoubleField>("width").value, 0.01);
            field.ShowPoints();
            panel.Click(At(400), clicks: 2);
            Assert.That((function.shift, function.windowScale), Is.EqualTo((0f, 1f)));
        }

        [Test]
        public void ColoursAreAddedMovedPaintedAndRemoved()
        {
            var at = field.Colors.worldBound.position + new Vector2(field.Colors.PixelOf(100), 24);
            panel.Click(at, clicks: 2);
            Assert.That(function.colorStops.Count, Is.EqualTo(3));
            Assert.That(field.Colors.Selected, Is.EqualTo(1));
            Drag(Stop(1), Stop(1) + new Vector2(25, 0));
            Assert.That(function.colorStops[1].value, Is.GreaterThan(102));
            field.Q<TextField>("hex").value = "#3366cc";
            Near(0.2, function.colorStops[1].color.r, 0.01);
            Near(0.8, function.colorStops[1].color.b, 0.01);
            var steps = field.History.Count;
            foreach (var hue in new[] { 0.1f, 0.2f, 0.3f }) field.Q<Slider>("hue").value = hue;
            Assert.That(field.History.Count, Is.EqualTo(steps), "a dragged slider goes on with the edit before");
            field.Q<TextField>("hex").value = "no colour";
            Assert.That(field.Q<TextField>("hex").value, Does.StartWith("#"));
            panel.Click(Stop(1), 1);
            Assert.That(function.colorStops.Count, Is.EqualTo(2));
        }

        [Test]
        public void NumbersAreTyped()
        {
            panel.Click(Knot(1));
            Near(100, field.Q<DoubleField>("knot-value").value, 1e-4);
            field.Q<DoubleField>("knot-value").value = 120;
            field.Q<DoubleField>("knot-opacity").value = 0.75;
            field.Q<Toggle>("knot-ease").value = true;
            var knot = function.opacityKnots[1];
            Assert.That((knot.value, knot.opacity, knot.ease), Is.EqualTo((120f, 0.75f, LumivoxTransferFunction.Ease.InOut)));
            // Beyond a neighbour it stops there, and says so.
            field.Q<DoubleField>("knot-value").value = 900;
            Assert.That(field.Q<DoubleField>("knot-value").value, Is.LessThanOrEqualTo(200));
            field.Q<DoubleField>("knot-opacity").value = 7;
            Near(1, field.Q<DoubleField>("knot-opacity").value, 1e-6);
        }

        [Test]
        public void WhatAScriptSetsIsShownAndDropsADrag()
        {
            panel.PointerDown(Knot(1));
            panel.PointerMove(Knot(1) + new Vector2(20, 0));
            function.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(5, 0.25f) }, null);
            panel.Update();
            Assert.That(field.Model.Knots.Count, Is.EqualTo(1));
            panel.PointerMove(Knot(0) + new Vector2(80, 0));
            panel.PointerUp(Knot(0) + new Vector2(80, 0));
            Assert.That(function.opacityKnots.Single().value, Is.EqualTo(5));
        }

        [Test]
        public void AFunctionWithoutPointsInvitesToGiveItSome()
        {
            var empty = ScriptableObject.CreateInstance<LumivoxTransferFunction>();
            field.transferFunction = empty;
            panel.Update();
            Assert.That(field.Query<Label>().ToList().Any(label => label.text.StartsWith("Double-click") && label.resolvedStyle.display == DisplayStyle.Flex));
            panel.Click(InGraph(300, 40), clicks: 2);
            Near(300, empty.opacityKnots.Single().value, 10);
            Assert.That(empty.colorStops.Count, Is.EqualTo(1));
            Object.DestroyImmediate(empty);
        }

        [Test]
        public void ResetGoesBackToWhatItWasWhenItWasOpened()
        {
            var before = function.GetState();
            Drag(Knot(1), Knot(1) + new Vector2(40, 30));
            panel.Click(field.Q<Button>("reset").worldBound.center);
            Assert.That(Menus.IsEnabled("Reset window"), Is.False);
            Menus.Choose("As it was when it was opened");
            Assert.That(function.GetState(), Is.EqualTo(before));
        }

        [Test]
        public void AnElementThatIsNotShownListensToNothing()
        {
            field.RemoveFromHierarchy();
            function.SetPoints(new[] { new LumivoxTransferFunction.OpacityKnot(5, 0.25f) }, null);
            Assert.That(field.Model.Knots.Count, Is.EqualTo(3));
            panel.visualTree.Add(field);
            panel.Update();
            Assert.That(field.Model.Knots.Count, Is.EqualTo(1));
        }

        [Test]
        public void WhatIsDrawnFacesTheViewerAndShowsTheCurve()
        {
            foreach (var element in new VisualElement[] { field.Graph, field.Colors })
            {
                var meshes = panel.DrawnBy(element).Where(shape => shape.Vertices.Length > 0).ToList();
                Assert.That(meshes, Is.Not.Empty);
                foreach (var mesh in meshes)
                    for (var i = 0; i < mesh.Indices.Length; i += 3)
                    {
                        Vector3 a = mesh.Vertices[mesh.Indices[i]].position, b = mesh.Vertices[mesh.Indices[i + 1]].position, c = mesh.Vertices[mesh.Indices[i + 2]].position;
                        // Down is positive: clockwise triangles have a positive area.
                        Assert.That((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y), Is.GreaterThanOrEqualTo(-1e-3));
                    }
            }
            var curve = panel.DrawnBy(field.Graph).Where(shape => !shape.IsFilled && shape.Points.Length > 20).Last();
            Assert.That(curve.Points.Zip(curve.Points.Skip(1), (a, b) => b.x >= a.x && b.y <= a.y + 1e-3f).All(rises => rises), "opacity rises to the right");
            field.Q<Button>("emphasise").SendEvent(new ClickEvent());
            panel.Update();
            var emphasised = panel.DrawnBy(field.Graph).Where(shape => !shape.IsFilled && shape.Points.Length > 20).Last();
            Assert.That(emphasised.Points[emphasised.Points.Length / 4].y, Is.LessThan(curve.Points[curve.Points.Length / 4].y));
        }

        [Test]
        public void WithoutAFunctionNothingCanBeDone()
        {
            field.transferFunction = null;
            panel.Update();
            panel.Click(field.Graph.worldBound.center, clicks: 2);
            panel.Click(field.Colors.worldBound.center, clicks: 2);
            Drag(field.Window.worldBound.center, field.Window.worldBound.center + new Vector2(30, 0));
            panel.Key(KeyCode.Delete);
            Assert.That(field.Model.IsEmpty);
            Assert.That(field.Q<DoubleField>("level").enabledSelf, Is.False);
        }

        [Test]
        public void MixedColoursGoThereAndBack()
        {
            for (var hue = 0; hue < 12; hue++)
            {
                var color = ColorMixer.Mixed(hue / 12f, 0.6f, 0.8f);
                var (h, s, v) = ColorMixer.Parts(color);
                Near(hue / 12f, h, 1e-4);
                Near(0.6, s, 1e-4);
                Near(0.8, v, 1e-4);
            }
            Assert.That(ColorMixer.Mixed(0, 1, 1), Is.EqualTo(Color.red));
            Near(1, ColorMixer.Mixed(1 / 3f, 1, 1).g, 1e-5);
        }
    }
}

// Light that is kept in volumes: clean pictures of what moves, unless it is turned off or finds no room.
using System.Linq;
using NUnit.Framework;
using StandIn;
using UnityEngine;

namespace Lumivox.Tests
{
    public sealed class RuntimeKeptLightTests : CubeScene
    {
        /// Frames for which the camera moves.
        const int Moving = 16;

        protected override float Scale => 8f;

        LumivoxEffect Effect => camera.GetComponent<LumivoxEffect>();

        void Look(int frame)
        {
            camera.transform.position = Quaternion.Euler(0f, 0.6f * frame, 0f) * new Vector3(0f, 0f, -0.3f);
            camera.transform.LookAt(Vector3.zero);
            Engine.Frame();
            Ticker.Tick();
        }

        /// Until there is something to see: the scan is prepared by another thread.
        void Arrive()
        {
            Waiting.Turns(() => LumivoxRenderer.GetStatus(camera).pixelSamples > 0, () => Look(0));
        }

        /// What is seen in the last of the frames.
        Picture Moved()
        {
            (Effect.targetSamples, Effect.frameBudgetMs) = (4096, 0.5f);
            Arrive();
            for (var frame = 0; frame < Moving; frame++) Look(frame);
            return Pictures.Color(camera);
        }

        /// In the middle: the cube's edges, which are sharp, have one ray a pixel.
        static double Error(Picture picture, Picture converged)
        {
            var pixels = Enumerable.Range(0, 64).Select(i => (X: Side / 2 - 4 + i % 8, Y: Side / 2 - 4 + i / 8));
            return System.Math.Sqrt(pixels.Average(at => System.Math.Pow(Light(picture.At(at.X, at.Y)) - Light(converged.At(at.X, at.Y)), 2)));
        }

        [Test]
        public void WhatMovesIsNearerToItsConvergedPictureWithIt()
        {
            volume.density = 0.5f;
            Assert.IsTrue(Effect.keptLight, "it is on by default");
            var kept = Moved();
            Assert.IsTrue(LumivoxRenderer.KeptLightBytes > 0, $"{LumivoxRenderer.GetStatus(camera).samples} samples, '{LumivoxRenderer.LastError}'");
            LumivoxRuntime.Stop();
            Effect.keptLight = false;
            var plain = Moved();
            Assert.AreEqual(0, LumivoxRenderer.KeptLightBytes);
            (Effect.targetSamples, Effect.frameBudgetMs) = (512, 1000f);
            Settle();
            var converged = Pictures.Color(camera);
            double ofKept = Error(kept, converged), ofPlain = Error(plain, converged);
            Assert.IsTrue(ofKept < 0.7 * ofPlain, $"{ofKept} with kept light, {ofPlain} without");
            Assert.AreEqual("", LumivoxRenderer.LastError);
        }

        [Test]
        public void AtRestThePictureIsTheSameWithItAndWithout()
        {
            volume.density = 0.5f;
            for (var frame = 0; frame < 4; frame++) Look(frame);
            Settle();
            var with = Pictures.Color(camera);
            LumivoxRuntime.Stop();
            Effect.keptLight = false;
            Settle();
            var without = Pictures.Color(camera);
            for (var i = 0; i < Side * Side; i++) Assert.AreEqual(without.At(i % Side, i / Side), with.At(i % Side, i / Side));
        }

        [Test]
        public void WhereThereIsNoMemoryForItNothingIsSaidAndThePictureIsThere()
        {
            Effect.keptLight = false;
            Effect.frameBudgetMs = 0.5f;
            Effect.targetSamples = 4096;
            Arrive();
            for (var frame = 0; frame < 4; frame++) Look(frame);
            Effect.keptLight = true;
            Faults.allocationsLeft = 1;
            Look(4);
            Faults.Clear();
            for (var frame = 5; frame < 9; frame++) Look(frame);
            Assert.AreEqual("", LumivoxRenderer.LastError);
            Assert.AreEqual(0, LumivoxRenderer.KeptLightBytes);
            Assert.IsTrue(Light(At(Pictures.Color(camera), 0.5f, 0.5f)) > 0.02f);
            // Of a device that is made anew nobody knows that.
            LumivoxRuntime.Stop();
            Arrive();
            for (var frame = 0; frame < 4; frame++) Look(frame);
            Assert.IsTrue(LumivoxRenderer.KeptLightBytes > 0);
        }
    }
}
